#include <momentree/math/spatial.hpp>

#include <cmath>
#include <initializer_list>

#include <doctest/doctest.h>

using namespace momentree;

namespace {

const Vec3 a{0.3, -1.2, 0.7}, b{-0.4, 0.25, 2.0}, c{1.1, 0.6, -0.9}, d{0.2, 0.8, -0.35};

Mat3 skew(const Vec3& v) { return {0, -v.z, v.y, v.z, 0, -v.x, -v.y, v.x, 0}; }

RigidMass some_body() {
  const double m = 1.7;
  const double cc = dot(c, c);
  return {m, m * c,
          Sym3{m * (cc - c.x * c.x) + 0.2, m * (cc - c.y * c.y) + 0.3, m * (cc - c.z * c.z) + 0.4, -m * c.x * c.y + 0.01,
               -m * c.x * c.z - 0.02, -m * c.y * c.z + 0.03}};
}

}  // namespace

TEST_CASE("(5) the cross product is the skew matrix times the vector") { CHECK(norm(cross(a, b) - skew(a) * b) < 1e-15); }

TEST_CASE("(4) the momentum of a rigid body is that of its centre of mass and of its rotation") {
  const RigidMass body = some_body();
  const Motion<double> O{a, b};
  const Force<double> P = momentum(body, O);
  CHECK(norm(P.l - body.m * (a + cross(b, c))) < 1e-14);
  const Sym3 Ic{0.2, 0.3, 0.4, 0.01, -0.02, 0.03};
  CHECK(norm(P.h - (Ic * b + cross(c, P.l))) < 1e-14);
  SpatialMass<double> M{};
  add_rigid_mass(M, body);
  const Force<double> Q = M * O;
  CHECK(norm(P.l - Q.l) < 1e-14);
  CHECK(norm(P.h - Q.h) < 1e-14);
}

TEST_CASE("(9) the rate at which a rigid body's momentum rotates is the cross product of its velocity and momentum") {
  const RigidMass body = some_body();
  const Motion<double> O{a, b};
  const Force<double> W = gyroscopic_wrench(body, O), X = cross(O, momentum(body, O));
  CHECK(norm(W.l - X.l) < 1e-14);
  CHECK(norm(W.h - X.h) < 1e-14);
}

TEST_CASE("(9) the cross products of motions and of forces are negative transposes of each other") {
  const Motion<double> O{a, b}, V{c, d};
  const Force<double> P{d, a};
  CHECK(dot(cross(O, V), P) == doctest::Approx(-dot(V, cross(O, P))).epsilon(1e-14));
  const Force<double> Q = cross(O, P);
  CHECK(norm(Q.l - cross(b, d)) < 1e-15);
  CHECK(norm(Q.h - (cross(a, d) + cross(b, a))) < 1e-15);
}

TEST_CASE("(16) shifting and rotating a mass matrix keeps its kinetic energy and momentum") {
  SpatialMass<double> M{};
  add_rigid_mass(M, some_body());
  // An articulated mass: not that of any rigid body.
  M.A.xx += 0.5, M.B.xy += 0.1, M.B.zz -= 0.2;
  const Motion<double> outer{a, b};
  SUBCASE("shift") {
    Motion<double> inner = outer;
    shift_outboard(inner, d);
    Force<double> P = M * inner;
    shift(P, d);
    SpatialMass<double> moved = M;
    shift(moved, d);
    const Force<double> Q = moved * outer;
    CHECK(norm(P.l - Q.l) < 1e-14);
    CHECK(norm(P.h - Q.h) < 1e-14);
  }
  SUBCASE("turns about x and z, and any rotation") {
    const double cos = std::cos(0.7), sin = std::sin(0.7);
    SpatialMass<double> z = M, x = M, any = M;
    rotate_z(z, cos, sin);
    rotate_x(x, cos, sin);
    rotate(any, Mat3{cos, -sin, 0, sin, cos, 0, 0, 0, 1});
    const auto turned_back = [&](Motion<double> m, bool about_z) {
      about_z ? rotate_z(m.v, cos, -sin) : rotate_x(m.v, cos, -sin);
      about_z ? rotate_z(m.w, cos, -sin) : rotate_x(m.w, cos, -sin);
      return m;
    };
    for (bool about_z : {true, false}) {
      const Motion<double> in = turned_back(outer, about_z);
      Force<double> P = M * in;
      about_z ? rotate_z(P.l, cos, sin) : rotate_x(P.l, cos, sin);
      about_z ? rotate_z(P.h, cos, sin) : rotate_x(P.h, cos, sin);
      const Force<double> Q = (about_z ? z : x) * outer;
      CHECK(norm(P.l - Q.l) < 1e-14);
      CHECK(norm(P.h - Q.h) < 1e-14);
    }
    const Force<double> P = z * outer, Q = any * outer;
    CHECK(norm(P.l - Q.l) < 1e-14);
    CHECK(norm(P.h - Q.h) < 1e-14);
  }
}

TEST_CASE("rotations: quaternion, matrix, vector, roll-pitch-yaw agree") {
  const Vec3 phi{0.4, -0.9, 1.3};
  const Quat q = exp_rotation(phi);
  CHECK(norm(log_rotation(q) - phi) < 1e-15);
  const Quat back = quaternion_of(rotation_matrix(q));
  CHECK(std::fabs(back.w - q.w) + std::fabs(back.x - q.x) + std::fabs(back.y - q.y) + std::fabs(back.z - q.z) < 1e-15);
  CHECK(norm(rotation_matrix(q) * phi - phi) < 1e-15);
  const Mat3 R = rotation_matrix(from_rpy(0.1, 0.2, 0.3));
  const Mat3 S = rotation_matrix(exp_rotation({0, 0, 0.3})) * rotation_matrix(exp_rotation({0, 0.2, 0})) *
                 rotation_matrix(exp_rotation({0.1, 0, 0}));
  CHECK(norm(R * a - S * a) < 1e-15);
  for (const Vec3& half_turn : {Vec3{3.14159265358979, 0, 0}, Vec3{0, 3.1415, 0}, Vec3{0, 0, -3.14159}}) {
    const Quat h = quaternion_of(rotation_matrix(exp_rotation(half_turn)));
    CHECK(norm(rotation_matrix(h) * b - rotation_matrix(exp_rotation(half_turn)) * b) < 1e-14);
  }
  const Pose pose{a, q};
  CHECK(norm(inverse(pose) * (pose * b) - b) < 1e-15);
}
