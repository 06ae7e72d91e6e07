#include <momentree/models/sdf/frames.hpp>

#include <algorithm>
#include <utility>

#include <momentree/base/error.hpp>
#include <momentree/text/diagnostic.hpp>

namespace momentree::io::sdf {

namespace {

XmlLocation name_spot(XmlElement element) {
  const auto i = element.find("name");
  return {element, i ? *i : XmlLocation::no_attribute};
}
std::size_t at(int index) { return static_cast<std::size_t>(index); }

}  // namespace

Frames::Frames(const ModelPart& outermost, Import& import) : import_(import) {
  frames_.reserve(2 * outermost.all_links + 16);
  open(outermost, -1, nullptr);
  relate();
  if (!sound_) return;
  check_attachments();
  place_models();
  if (sound_) place_all();
}

void Frames::error(const XmlLocation& location, std::string what, std::string hint) {
  import_.file_of(location.element).error(location, std::move(what), std::move(hint));
  sound_ = false;
}

int Frames::add(int scope, const std::string& name, XmlElement element, const Pose& pose) {
  Frame frame;
  frame.scope = scope;
  frame.name = &name;
  frame.element = element;
  frame.pose = pose;
  frames_.push_back(frame);
  return static_cast<int>(frames_.size()) - 1;
}

// Links, joints, frames and models share one namespace; before 1.7 only those of the same type do, and a link takes precedence
// over a joint.
void Frames::note_name(int scope, const std::string& name, int frame) {
  const auto [first, fresh] = scopes_[at(scopes_[at(scope)].names)].frames.emplace(name, frame);
  if (fresh) return;
  const Frame &one = frames_[at(first->second)], &other = frames_[at(frame)];
  if (!scopes_[at(scope)].part->version.frames() && one.element.name() != other.element.name()) return;
  XmlFile& file = import_.file_of(one.element);
  const bool elsewhere = !file.has(other.element);
  error(name_spot(other.element), "duplicate " + std::string(other.element.name()) + " " + in_quotes(name) +
                                      ": the name is already used by " +
                                      (one.element.name() == other.element.name() ? "another" : "the " + one.element.tag()) +
                                      " on " + file.line_of(one.element) + (elsewhere ? " of " + in_quotes(file.path()) : ""));
}

void Frames::open(const ModelPart& part, int parent, const NestedPart* nested) {
  const int index = static_cast<int>(scopes_.size());
  scopes_.emplace_back();
  nested_.push_back(nested);
  const bool merged = nested && nested->merged;
  {
    Scope& scope = scopes_.back();
    scope.part = &part;
    scope.parent = parent;
    scope.names = merged ? scopes_[at(parent)].names : index;
    scope.is_static = (nested ? nested->is_static : part.is_static) || (parent >= 0 && scopes_[at(parent)].is_static);
    if (parent >= 0) scope.prefix = scopes_[at(parent)].prefix + (merged ? "" : nested->name + "::");
  }
  const std::string& name = nested ? nested->name : part.name;
  const Pose pose = nested ? nested->pose.pose : part.pose.pose;
  const int own = add(index, name, nested ? nested->element : part.element, pose);
  scopes_[at(index)].own_frame = own;
  if (parent >= 0 && !merged) {
    note_name(parent, name, own);
    scopes_[at(scopes_[at(parent)].names)].scopes.emplace(name, index);
  }
  scopes_[at(index)].first_link = static_cast<int>(frames_.size());
  for (const LinkPart& link : part.links) {
    const int frame = add(index, link.name, link.element, link.pose.pose);
    frames_.back().link = static_cast<int>(links_++);
    note_name(index, link.name, frame);
  }
  scopes_[at(index)].first_frame = static_cast<int>(frames_.size());
  for (const FramePart& each : part.frames) note_name(index, each.name, add(index, each.name, each.element, each.pose.pose));
  scopes_[at(index)].first_joint = static_cast<int>(frames_.size());
  for (const JointPart& each : part.joints) note_name(index, each.name, add(index, each.name, each.element, each.pose.pose));
  for (const NestedPart& each : part.nested) open(*each.model, index, &each);
}

int Frames::find(int scope, std::string_view name) const {
  for (;;) {
    const Scope& here = scopes_[at(scope)];
    if (name == "__model__" && !here.part->is_world) return here.own_frame;
    if (name == "world" && here.part->is_world) return here.own_frame;
    const Scope& names = scopes_[at(here.names)];
    const auto found = names.frames.find(name);
    if (found != names.frames.end()) return found->second;
    const std::size_t colons = name.find("::");
    if (colons == std::string_view::npos) return Frame::unknown;
    const auto inner = names.scopes.find(name.substr(0, colons));
    if (inner == names.scopes.end()) return Frame::unknown;
    scope = inner->second;
    name.remove_prefix(colons + 2);
  }
}

int Frames::look_up(int scope, const std::string& name, const XmlLocation& location, const char* what) {
  const int found = find(scope, name);
  if (found != Frame::unknown) return found;
  std::vector<std::string> known;
  const auto& names = scopes_[at(scopes_[at(scope)].names)].frames;
  if (names.size() < 2000)
    for (const auto& [each, frame] : names) known.emplace_back(each);
  std::sort(known.begin(), known.end());
  std::string hint = did_you_mean(name, known);
  if (hint.empty() && name == "world") hint = "within a model only a joint's parent can be the world";
  error(location, std::string(what) + ": there is no link, joint, frame or model " + in_quotes(name) + " here", hint);
  return Frame::unknown;
}

int Frames::base(int scope, const FramedPose& pose, int otherwise) {
  return pose.relative_to.empty() ? otherwise : look_up(scope, pose.relative_to, pose.location, "pose");
}

// Determines what each frame is relative to, and attached to.
void Frames::relate() {
  for (int s = 0; s < static_cast<int>(scopes_.size()); ++s) {
    const Scope& scope = scopes_[at(s)];
    const ModelPart& part = *scope.part;
    const NestedPart* nested = nested_[at(s)];
    Frame& own = frames_[at(scope.own_frame)];
    if (scope.parent >= 0) {
      own.relative_to = base(scope.parent, nested->pose, scopes_[at(scope.parent)].own_frame);
    } else if (!part.pose.relative_to.empty()) {
      error(part.pose.location, "pose: the outermost model can be placed only in the world");
    }
    // Its canonical link: the one that it names, its first link, or that of its first model.
    if (!part.canonical_link.empty())
      own.attached_to = look_up(s, part.canonical_link, part.canonical_spot, "canonical_link");
    else if (!part.links.empty())
      own.attached_to = scope.first_link;
    else if (!part.is_world)
      for (int inner = s + 1; inner < static_cast<int>(scopes_.size()) && own.attached_to == Frame::nothing; ++inner)
        if (scopes_[at(inner)].parent == s) own.attached_to = scopes_[at(inner)].own_frame;
    if (scope.is_static) own.attached_to = Frame::nothing;
    for (std::size_t i = 0; i < part.links.size(); ++i)
      frames_[at(scope.first_link) + i].relative_to = base(s, part.links[i].pose, scope.own_frame);
    for (std::size_t i = 0; i < part.frames.size(); ++i) {
      Frame& frame = frames_[at(scope.first_frame) + i];
      const FramePart& each = part.frames[i];
      frame.attached_to =
          each.attached_to.empty() ? scope.own_frame : look_up(s, each.attached_to, each.attached_spot, "attached_to");
      frame.relative_to = base(s, each.pose, frame.attached_to);
    }
    for (std::size_t i = 0; i < part.joints.size(); ++i) {
      Frame& frame = frames_[at(scope.first_joint) + i];
      const JointPart& each = part.joints[i];
      if (each.child == "world") {
        error(each.child_spot, "child: the world cannot be a joint's child", "swap parent and child, and reverse the axis");
        continue;
      }
      frame.attached_to = look_up(s, each.child, each.child_spot, "child");
      frame.relative_to = base(s, each.pose, frame.attached_to);
    }
  }
}

void Frames::report_circle(int start, bool attached) {
  std::string names;
  int shown = 0;
  for (int f = start;;) {
    if (++shown <= 8) names += in_quotes(*frames_[at(f)].name) + (attached ? " attached to " : " relative to ");
    f = attached ? frames_[at(f)].attached_to : frames_[at(f)].relative_to;
    if (f == start) break;
  }
  names += shown > 8 ? "…" : in_quotes(*frames_[at(start)].name);
  error(name_spot(frames_[at(start)].element), "frames form a cycle: " + names, "one of them must lead to the model");
}

namespace {
enum State : char { unseen, walking, done };
}

void Frames::check_attachments() {
  std::vector<char> state(frames_.size(), unseen);
  std::vector<int> path;
  for (int start = 0; start < static_cast<int>(frames_.size()); ++start) {
    path.clear();
    int f = start;
    for (; f >= 0 && state[at(f)] == unseen; f = frames_[at(f)].link >= 0 ? -1 : frames_[at(f)].attached_to) {
      state[at(f)] = walking;
      path.push_back(f);
    }
    if (f >= 0 && state[at(f)] == walking) report_circle(f, true);
    for (const int each : path) state[at(each)] = done;
  }
}

// A placement frame is at the model's pose: the model's own frame follows from that. Inner models first.
void Frames::place_models() {
  for (int s = static_cast<int>(scopes_.size()); s-- > 0;) {
    const Scope& scope = scopes_[at(s)];
    const NestedPart* nested = nested_[at(s)];
    const std::string& name = nested ? nested->placement_frame : scope.part->placement_frame;
    if (name.empty()) continue;
    const int placed = look_up(s, name, nested ? nested->placement_spot : scope.part->placement_spot, "placement_frame");
    if (placed == Frame::unknown) continue;
    Pose in_model;
    int f = placed;
    for (std::size_t steps = 0; f != scope.own_frame && f >= 0 && steps <= frames_.size(); ++steps) {
      in_model = frames_[at(f)].pose * in_model;
      f = frames_[at(f)].relative_to;
    }
    if (f != scope.own_frame) {
      error(nested ? nested->placement_spot : scope.part->placement_spot,
            "placement_frame: the place of " + in_quotes(name) + " is not determined by the model's",
            "it must be relative to the model or one of its parts");
      continue;
    }
    Frame& own = frames_[at(scope.own_frame)];
    own.pose = own.pose * inverse(in_model);
  }
}

void Frames::place_all() {
  std::vector<char> state(frames_.size(), unseen);
  std::vector<int> path;
  for (int start = 0; start < static_cast<int>(frames_.size()); ++start) {
    path.clear();
    int f = start;
    for (; f >= 0 && state[at(f)] == unseen; f = frames_[at(f)].relative_to) {
      state[at(f)] = walking;
      path.push_back(f);
    }
    if (f >= 0 && state[at(f)] == walking) report_circle(f, false);
    for (auto each = path.rbegin(); each != path.rend(); ++each) {
      Frame& frame = frames_[at(*each)];
      frame.placed = frame.relative_to >= 0 ? frames_[at(frame.relative_to)].placed * frame.pose : frame.pose;
      frame.placed.rotation = normalized(frame.placed.rotation);
      state[at(*each)] = done;
    }
  }
}

int Frames::link_of(int frame) const {
  while (frame >= 0 && frames_[at(frame)].link < 0) frame = frames_[at(frame)].attached_to;
  return frame;
}

// As written in the file, if possible, to avoid rounding errors.
Pose Frames::between(int a, int b) const {
  const Frame &from = frames_[at(a)], &to = frames_[at(b)];
  if (a == b) return {};
  if (to.relative_to == a) return to.pose;
  if (from.relative_to == b) return inverse(from.pose);
  return inverse(from.placed) * to.placed;
}

}  // namespace momentree::io::sdf
