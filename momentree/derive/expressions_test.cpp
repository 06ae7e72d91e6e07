#include <momentree/derive/expressions.hpp>

#include <doctest/doctest.h>

namespace momentree {

namespace {
struct Two : Expressions {
  int x = input(Operation::q, 0), y = input(Operation::p, 0);
  int c(double value) { return constant(value); }
};
}  // namespace

TEST_CASE("constants are folded, zeros and ones are left out") {
  Two e;
  CHECK(e.zero == e.c(0));
  CHECK(e.c(-0.0) == e.zero);
  CHECK(e.sum(e.c(2), e.c(0.5)) == e.c(2.5));
  CHECK(e.difference(e.c(2), e.c(0.5)) == e.c(1.5));
  CHECK(e.product(e.c(2), e.c(0.5)) == e.c(1));
  CHECK(e.quotient(e.c(2), e.c(0.5)) == e.c(4));
  CHECK(e.sum(e.x, e.zero) == e.x);
  CHECK(e.sum(e.zero, e.x) == e.x);
  CHECK(e.difference(e.x, e.zero) == e.x);
  CHECK(e.difference(e.x, e.x) == e.zero);
  CHECK(e.product(e.zero, e.x) == e.zero);
  CHECK(e.product(e.x, e.c(1)) == e.x);
  CHECK(e.product(e.c(3), e.product(e.x, e.c(2))) == e.product(e.c(6), e.x));
  CHECK(e.quotient(e.x, e.c(1)) == e.x);
  CHECK(e.quotient(e.zero, e.x) == e.zero);
  e.cancel_terms();
  const int x_and_y = e.sum(e.x, e.y), x_less_y = e.difference(e.x, e.y);
  CHECK(e.difference(x_and_y, e.x) == e.y);
  CHECK(e.difference(x_and_y, e.y) == e.x);
  CHECK(e.difference(e.x, x_and_y) == e.negative(e.y));
  CHECK(e.difference(e.y, x_and_y) == e.negative(e.x));
  CHECK(e.sum(x_less_y, e.y) == e.x);
  CHECK(e.sum(e.y, x_less_y) == e.x);
  CHECK(e.difference(e.x, x_less_y) == e.y);
  CHECK(e.difference(x_less_y, e.x) == e.negative(e.y));
  const auto square = [&](int a) { return e.product(a, a); };
  CHECK(e.sum(square(e.sine(e.x)), square(e.cosine(e.x))) == e.c(1));
  CHECK(e.sum(square(e.cosine(e.x)), square(e.sine(e.x))) == e.c(1));
  CHECK(e.sum(square(e.cosine(e.x)), square(e.sine(e.y))) != e.c(1));
  CHECK(e.sine(e.zero) == e.zero);
  CHECK(e.cosine(e.zero) == e.c(1));
}

TEST_CASE("signs move outward") {
  Two e;
  const int minus = e.negative(e.x);
  CHECK(e.negative(minus) == e.x);
  CHECK(e.product(e.c(-1), e.x) == minus);
  CHECK(e.product(e.c(-3), e.x) == e.negative(e.product(e.c(3), e.x)));
  CHECK(e.product(minus, e.negative(e.y)) == e.product(e.x, e.y));
  CHECK(e.product(e.y, minus) == e.negative(e.product(e.x, e.y)));
  CHECK(e.sum(e.y, minus) == e.difference(e.y, e.x));
  CHECK(e.sum(minus, e.y) == e.difference(e.y, e.x));
  CHECK(e.sum(minus, e.negative(e.y)) == e.negative(e.sum(e.x, e.y)));
  CHECK(e.difference(e.y, minus) == e.sum(e.x, e.y));
  CHECK(e.difference(minus, e.y) == e.negative(e.sum(e.x, e.y)));
  CHECK(e.difference(e.zero, e.x) == minus);
  CHECK(e.sum(e.x, e.c(-2)) == e.difference(e.x, e.c(2)));
  CHECK(e.difference(e.x, e.c(-2)) == e.sum(e.x, e.c(2)));
  CHECK(e.quotient(minus, e.y) == e.negative(e.quotient(e.x, e.y)));
}

TEST_CASE("equal expressions are one node; only nodes that the results need are counted") {
  Two e;
  CHECK(e.sum(e.x, e.y) == e.sum(e.y, e.x));
  CHECK(e.product(e.x, e.y) == e.product(e.y, e.x));
  CHECK(e.difference(e.x, e.y) == e.negative(e.difference(e.y, e.x)));
  CHECK(e.input(Operation::q, 0) == e.x);
  CHECK(e.input(Operation::q, 1) != e.x);
  const int s = e.sine(e.x), c = e.cosine(e.x);
  e.quotient(e.x, e.y);  // not used by any result
  const int square = e.product(s, s), result = e.difference(e.sum(square, square), e.product(c, e.y));
  const int results[] = {result, e.negative(result)};
  const Operations o = e.operations(results);
  CHECK(o.additions == 2);
  CHECK(o.multiplications == 2);
  CHECK(o.divisions == 0);
  CHECK(o.sincos == 1);
}

}  // namespace momentree
