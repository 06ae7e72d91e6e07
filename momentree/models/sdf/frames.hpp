#pragma once
// The frames of all models and how they are attached: names become indices, placements become poses. Internal to the importer.
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include <momentree/models/sdf/parts.hpp>

namespace momentree::io::sdf {

/// One instance of a model, or the world.
struct Scope {
  const ModelPart* part = nullptr;
  int parent = -1;     ///< the enclosing scope
  int names = -1;      ///< the scope of its names: its own, or the one that it was merged into
  int own_frame = -1;  ///< its __model__ frame, or the world's frame
  int first_link = -1, first_frame = -1, first_joint = -1;  ///< the frames of its parts are contiguous
  bool is_static = false;
  std::string prefix;                                  ///< of the full names of its parts: "a::b::"
  std::unordered_map<std::string_view, int> frames;    ///< by name
  std::unordered_map<std::string_view, int> scopes{};  ///< nested models by name
};

struct Frame {
  static constexpr int nothing = -1, unknown = -2;
  int scope = -1;
  int relative_to = nothing;
  int attached_to = nothing;  ///< for frames that do not belong to a link
  int link = nothing;         ///< the index of the link with this frame
  Pose pose{};                ///< in `relative_to`
  Pose placed{};              ///< in the outermost frame
  const std::string* name = nullptr;
  XmlElement element{};
};

class Frames {
 public:
  /// Reports unknown and duplicate names, and cycles of frames, in the files; sound() is then false.
  Frames(const ModelPart& outermost, Import& import);

  bool sound() const { return sound_; }
  const std::vector<Scope>& scopes() const { return scopes_; }
  const Frame& frame(int index) const { return frames_[static_cast<std::size_t>(index)]; }
  std::size_t links() const { return links_; }

  /// The frame of that name in a scope; `unknown` if there is none.
  int find(int scope, std::string_view name) const;
  /// Like find(), with a report at `at` if there is none.
  int look_up(int scope, const std::string& name, const XmlLocation& at, const char* what);
  /// The frame of the link that a frame moves with; `nothing`: the world.
  int link_of(int frame) const;
  /// The pose of frame b in frame a.
  Pose between(int a, int b) const;
  void error(const XmlLocation& at, std::string what, std::string hint = {});

 private:
  struct Placement {
    int scope, frame;
    const NestedPart* nested;
  };
  void open(const ModelPart& part, int parent, const NestedPart* nested);
  int add(int scope, const std::string& name, XmlElement element, const Pose& pose);
  void note_name(int scope, const std::string& name, int frame);
  void relate();
  int base(int scope, const FramedPose& pose, int otherwise);
  void place_models();
  void place_all();
  void check_attachments();
  void report_circle(int start, bool attached);

  Import& import_;
  std::vector<Scope> scopes_;
  std::vector<const NestedPart*> nested_;  // by scope
  std::vector<Frame> frames_;
  std::size_t links_ = 0;
  bool sound_ = true;
};

}  // namespace momentree::io::sdf
