#pragma once
// Which mechanism each body belongs to between the events, replayed from what the events did.
#include <string>
#include <vector>

#include <momentree/io/picture/recording.hpp>

namespace momentree::io {

/// Fills `phases`, `mechanisms` and the events' `broken`. `mechanism_of`: by body the name of its mechanism at the start.
/// Knows what takes bodies apart ("break JOINT") and joins them ("weld BODY to BODY", "attach …"); what the parts are called is
/// taken from the events, where they say it: else a part that comes off is named after its body.
void find_phases(Recording& run, const std::vector<std::string>& mechanism_of);

/// Takes the mechanisms of the last phase from the run's own final state: right also where a run began with another
/// topology than the model's.
void correct_last_phase(Recording& run, const std::vector<std::string>& mechanism_of);

}  // namespace momentree::io
