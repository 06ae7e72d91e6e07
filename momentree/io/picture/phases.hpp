#pragma once
// Which mechanism each body belongs to between the events, replayed from what the events did.
#include <string>
#include <vector>

#include <momentree/io/picture/recording.hpp>

namespace momentree::io {

/// Fills `phases`, `mechanisms` and the events' `broken`. `mechanism_of`: by body the name of its mechanism at the start.
/// Knows the action "break JOINT"; a part that comes off is a mechanism named after its root body.
void find_phases(Recording& run, const std::vector<std::string>& mechanism_of);

/// Takes the mechanisms of the last phase from the run's own final state: right also after actions that find_phases does not
/// know.
void correct_last_phase(Recording& run, const std::vector<std::string>& mechanism_of);

}  // namespace momentree::io
