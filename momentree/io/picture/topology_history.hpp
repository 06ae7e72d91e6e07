#pragma once
// Which mechanism each body belongs to between the events, from what the events recorded.
#include <string>
#include <unordered_map>
#include <vector>

#include <momentree/io/json_document.hpp>
#include <momentree/io/picture/recording.hpp>

namespace momentree::io {

/// Reads `changes` and `topology` of the lines of events.jsonl, one after the other, into `run.phases`, `run.mechanisms` and the
/// events' `broken` and `about`.
class TopologyHistory {
 public:
  /// `mechanism_of`: by body the name of its mechanism at the start.
  TopologyHistory(Recording& run, const std::vector<std::string>& mechanism_of);
  /// `event` is not yet in run.events. Throws Error that names the line where something is not as it should be.
  void add(const JsonDocument& line, RecordedEvent& event);

 private:
  struct Link {
    int parent = -1, child = -1;
    bool at_start = false;
  };
  int mechanism(const std::string& name);
  int body(const JsonDocument& line, const JsonNode& name) const;
  void note_changes(const JsonDocument& line, RecordedEvent& event) const;
  void remove(const std::string& joint, RecordedEvent& event, Phase& phase);
  void put(const JsonDocument& line, const std::string& name, const JsonNode& joint, RecordedEvent& event, Phase& phase);

  Recording& run_;
  std::unordered_map<std::string, int> bodies_;  // by name
  std::unordered_map<std::string, Link> links_;  // by joint
};

}  // namespace momentree::io
