// Invalid input of the generator.
#include <doctest/doctest.h>

#include <momentree/generate/kernel_cache.hpp>
#include <momentree/generate/source.hpp>
#include <momentree/simulate/simulation.hpp>
#include <tests/misuse.hpp>

using namespace momentree;
using namespace momentree::test;

TEST_CASE("misuse: expressions and sources") {
  const char* const no_node = "a node of these expressions";
  const Misuse all[] = {
      {"a sum of no node", no_node, [] { Expressions().sum(0, 7); }},
      {"a product of no node", no_node, [] { Expressions().product(-1, 0); }},
      {"a sine of no node", no_node, [] { Expressions().sine(3); }},
      {"operations of no node", no_node,
       [] {
         const int nodes[] = {0, 9};
         static_cast<void>(Expressions().operations(nodes));
       }},
      {"an operation that is not an input", "q, p and tau are the inputs", [] { Expressions().input(Operation::sum, 0); }},
      {"an input before the first", "an index into q, p or tau", [] { Expressions().input(Operation::q, -1); }},
      {"a source whose name is no identifier", "a name that is an identifier",
       [] { static_cast<void>(kernel_source(KernelExpressions(), {.name = "x; system(\"id\");", .about = ""})); }},
  };
  for (const Misuse& misuse : all) check_stopped(misuse);
}

TEST_CASE("a cache without code reports the reason, and simulations run without it") {
  Model model;
  model.add({.name = "bob", .mass = 1, .com = {0.1, 0, 0}, .inertia = diagonal(0.1), .joint = Revolute{}});
  KernelCacheOptions no_operations, no_topologies;
  no_operations.most_operations = -1;
  no_topologies.most_topologies = 0;
  for (const KernelCacheOptions& options : {no_operations, no_topologies}) {
    const KernelCache cache(options);
    CHECK((cache.find(Tree(model)) == nullptr) == true);
    CHECK((cache.find(Tree()) == nullptr) == true);
    CHECK_FALSE(cache.message().empty());
    Simulation sim(model);
    sim.use_generated(cache.provider());
    CHECK(sim.run_until(0.01) == Status::ok);
    CHECK(cache.statistics().compiled == 0);
  }
}
