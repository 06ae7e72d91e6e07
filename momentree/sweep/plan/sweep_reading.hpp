#pragma once
// The parts of a sweep's reader. Internal: other code uses read_sweep.hpp.
#include <string>
#include <vector>

#include <momentree/results/session.hpp>
#include <momentree/scenario/keys/fields.hpp>
#include <momentree/sweep/sweep.hpp>

namespace momentree::sweep {

struct SweepReading {
  Sweep& sweep;
  io::Diagnostics& out;
  std::vector<Variable> variables{};
  Place vary{};  ///< of [vary]
};

/// Reads one entry of [vary] and adds it as a parameter and a variable, unless it is wrong.
void read_vary(const Value::Entry& entry, SweepReading& reading);
/// The tables [[correlated]], for the parameters that have been read.
std::vector<Correlation> read_correlations(const Value& tables, SweepReading& reading);
/// [measure] and [stop], for the scenario of the session.
void read_measures(const Value& table, io::Session& session, SweepReading& reading);
void read_stop(const Value& table, const Simulation& simulation, SweepReading& reading);
/// Tries the values of the parameters: at the ends and in the middle of their ranges. Returns a hash of the scenarios that were
/// read: it identifies the files that entries of lists name. Throws Error if such a file cannot be read.
std::string try_parameters(SweepReading& reading);

}  // namespace momentree::sweep
