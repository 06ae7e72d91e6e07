#pragma once
// Determines the mechanism of each body between the events from the recorded events.
#include <string>
#include <unordered_map>
#include <vector>

#include <momentree/results/recording/record.hpp>
#include <momentree/results/recording/recording.hpp>

namespace momentree::io {

/// The numbers of bodies by name.
using BodyNumbers = std::unordered_map<std::string, int>;
/// −1: the ground, or not recorded.
int find_body(const BodyNumbers& numbers, const Value& name);
/// A joint of model.json, a state document or an event, whether or not it closes a loop. Without a child, nothing else is read.
RecordedLoop read_joint(const Value::Entry& entry, const BodyNumbers& numbers, Diagnostics& out);

/// Reads `changes` and `topology` of successive lines of events.jsonl into `run.phases`, `run.mechanisms` and the events'
/// `broken` and `impacts`.
class TopologyHistory {
 public:
  /// `mechanism_of`: for each body the name of its mechanism at the start.
  TopologyHistory(Recording& run, const BodyNumbers& numbers, const std::vector<std::string>& mechanism_of);
  /// `event` is not yet in run.events. Reports to `out` if the line is invalid.
  void add(Record& line, RecordedEvent& event, Diagnostics& out);

 private:
  struct Link {
    int parent = -1, child = -1;
    bool at_start = false;
  };
  int mechanism(const std::string& name);
  int loop(const std::string& name, const Phase& phase) const;  // index in run_.loops; −1: none
  void remove(const std::string& joint, RecordedEvent& event, Phase& phase);
  void unlink(const std::string& joint, RecordedEvent& event, Phase& phase);
  bool put_loop(RecordedLoop loop, bool closes, RecordedEvent& event, Phase& phase);
  void put(const Value::Entry& entry, RecordedEvent& event, Phase& phase, Diagnostics& out);

  Recording& run_;
  const BodyNumbers& numbers_;
  std::unordered_map<std::string, Link> links_;  // by joint
};

}  // namespace momentree::io
