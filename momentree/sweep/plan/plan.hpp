#pragma once
// The values that a sweep gives to each of its worlds.
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include <momentree/sweep/stats/distribution.hpp>

namespace momentree::sweep {

/// How uniform numbers are drawn before a distribution turns them into values.
enum class Sampling {
  random,  ///< independent
  latin,   ///< Latin hypercube: each of as many equally likely ranges as there are worlds occurs in exactly one world
  sobol,   ///< scrambled Sobol sequence
};

/// The entries of a list. The plan gives an index.
struct ListValues {
  std::size_t count;
};
/// `count` evenly spaced values, both ends included. With one value, `from`.
struct RangeValues {
  double from, to;
  std::size_t count;
};
/// Draws of distributions, one per component of a vector.
struct Sampled {
  Sampling how;
  std::vector<Distribution> components;
};

struct Variable {
  std::string key;
  std::variant<ListValues, RangeValues, Sampled> values;
};

/// Of two components drawn by Sampling::random or Sampling::sobol, numbered over all variables (lists and ranges have one).
/// `coefficient` is the correlation of the normal variables of a Gaussian copula: of the values themselves, if their
/// distributions are normal. Their rank correlation is 6/π asin(coefficient/2) for all continuous distributions.
struct Correlation {
  std::size_t a, b;
  double coefficient;
};

/// Immutable; used by any number of threads. Values of a world depend on the seed, the plan and the world's number alone. Random
/// draws of a variable depend on its key, not on the other variables.
class Plan {
 public:
  /// Without `worlds`, every combination of lists and ranges is a world; the last one varies fastest. With it, lists and ranges
  /// are drawn at random in each world. Throws Error, without a place: a variable without values, two with one key, impossible
  /// ranges, fewer than 1 or more than 2^48 worlds, more than sobol_dimensions components by Sampling::sobol, and correlations
  /// that are impossible (not between -1 and 1, contradictory, of a component with itself or drawn otherwise).
  Plan(std::vector<Variable> variables, std::optional<std::uint64_t> worlds, std::uint64_t seed,
       std::vector<Correlation> correlations = {});

  std::uint64_t worlds() const { return worlds_; }
  /// Number of components of all variables.
  std::size_t size() const { return components_.size(); }
  const std::vector<Variable>& variables() const { return variables_; }
  /// Writes the values of a world (< worlds()) to `out` (size() entries): an index for a list. Does not allocate.
  void values(std::uint64_t world, std::span<double> out) const;

 private:
  struct Component {
    std::size_t variable;
    std::size_t number;         ///< within the variable
    std::uint64_t stream;       ///< of random numbers
    std::uint64_t divisor = 1;  ///< for combinations: worlds with the same entry in a row
    int dimension = 0;          ///< of the Sobol sequence
    bool correlated = false;
  };
  void add_components();
  void count_worlds(std::optional<std::uint64_t> worlds);
  void add_correlations(const std::vector<Correlation>& correlations);
  std::string name(std::size_t component) const;
  double fraction(const Component& component, std::uint64_t world) const;
  std::uint64_t entry(const Component& component, std::uint64_t world) const;

  std::vector<Variable> variables_;
  std::vector<Component> components_;
  std::uint64_t worlds_ = 1, seed_;
  bool combinations_ = false;
  std::vector<std::size_t> correlated_;  ///< component numbers
  std::vector<double> factor_;           ///< lower triangle of the Cholesky factor of their correlations, by rows
};

}  // namespace momentree::sweep
