#include <momentree/scenario/state/state_contact.hpp>

#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <string>

#include <momentree/scenario/keys/described.hpp>
#include <momentree/simulate/stepping/overlap.hpp>

namespace momentree::io {

namespace {

constexpr std::array<const char*, 3> states{"smooth", "stick", "slip"};  // by Contact::Mode

const Collider& collider(const Model& model, int number) { return model.colliders()[static_cast<std::size_t>(number)]; }

// The colliders of each body, and the place of each collider among those of its body.
class Shapes {
 public:
  explicit Shapes(const Model& model) : of_body_(static_cast<std::size_t>(model.size()) + 1) {
    for (int i = 0; i < static_cast<int>(model.colliders().size()); ++i) {
      std::vector<int>& own = of_body_[at(collider(model, i).body)];
      places_.push_back(static_cast<int>(own.size()));
      own.push_back(i);
    }
  }
  int place_of(int number) const { return places_[static_cast<std::size_t>(number)]; }
  /// −1: the body has no collider in that place.
  int collider_of(BodyId body, double place) const {
    const std::vector<int>& own = of_body_[at(body)];
    if (!(place >= 0) || place != std::floor(place) || !(place < static_cast<double>(own.size()))) return -1;
    return own[static_cast<std::size_t>(place)];
  }

 private:
  static std::size_t at(BodyId body) { return static_cast<std::size_t>(body.index + 1); }  // the ground is the first one
  std::vector<std::vector<int>> of_body_;
  std::vector<int> places_;
};

// Bodies, shapes and features of a contact.
struct Who {
  BodyId one, other;
  int pair = -1, cable = -1;
  std::uint64_t id = 0;
};

void write_who(JsonWriter& json, const Model& model, const Shapes& shapes, const Who& who) {
  if (who.cable >= 0) json.member("cable", model.springs()[static_cast<std::size_t>(who.cable)].name);
  json.member("one", model.body_name(who.one)).member("other", model.body_name(who.other));
  if (who.cable >= 0) return;
  constexpr int stride = static_cast<int>(most_colliders);
  int first = who.pair / stride, second = who.pair % stride;
  if (collider(model, first).body != who.one) std::swap(first, second);
  json.key("shapes").begin_array().value(shapes.place_of(first)).value(shapes.place_of(second)).end_array();
}

void write_touching(JsonWriter& json, const Model& model, const Shapes& shapes, const Who& who) {
  write_who(json, model, shapes, who);
  if (who.cable < 0) json.member("feature", std::to_string(who.id));
}

void write_closed(JsonWriter& json, const Contact& contact) {
  json.member("state", states[static_cast<std::size_t>(contact.mode)]);
  if (contact.direction != Vec3{}) json.member("direction", contact.direction);
  if (contact.keeps_direction != 0) json.member("keeps_direction", contact.keeps_direction);
  if (contact.settles >= 0) json.member("settles", contact.settles);
  if (contact.pending) json.member("pending", true);
}

void write_point(JsonWriter& json, const ContactPoint& point) {
  json.member("point", point.point).member("normal", point.normal).member("force", point.force).member("slip", point.slip);
  if (!(point.moment == Vec3{})) json.member("moment", point.moment);
  if (point.determined) json.member("determined", *point.determined);
}

class ContactReader {
 public:
  ContactReader(const Value& entry, const Model& model, const Shapes& shapes, JointReader& joints, Diagnostics& out)
      : entry_(entry), model_(model), shapes_(shapes), joints_(joints), out_(out), fields_(entry, "a contact", out, "") {}

  void read(Forest& forest, SteppingState& stepping) {
    if (!entry_.table()) return;  // reported
    const std::size_t errors = out_.errors();
    const bool overlapping = fields_.boolean("overlapping").value_or(false);
    const Who who = read_who(overlapping);
    if (overlapping) return read_overlapping(who, errors, forest);
    const bool stepped = fields_.boolean("stepped").value_or(false);
    const bool pending = fields_.boolean("pending").value_or(false);
    const bool former = fields_.boolean("former").value_or(false);
    for (const char* result : {"released", "determined"}) static_cast<void>(fields_.boolean(result));
    SteppedContact point{who.pair, who.id, who.one.index, who.other.index, {}, {}, {}, {}, who.cable};
    for (const auto& [key, to] :
         {std::pair{"point", &point.point}, {"normal", &point.normal}, {"force", &point.force}, {"slip", &point.slip}})
      *to = vector(key, stepped);
    point.moment = vector("moment", false);
    Contact closed;
    closed.pair = who.pair, closed.id = who.id;
    read_closed(closed, stepped);
    fields_.finish();
    if (pending || errors != out_.errors()) return;
    if (stepped)
      read_point(point, stepping.points);
    else
      (former ? forest.former_contacts : forest.contacts).push_back(closed);
  }

 private:
  static constexpr const char* remedy = "leave out `contacts`: the run finds them anew";

  void read_overlapping(const Who& who, std::size_t errors, Forest& forest) {
    if (errors == out_.errors() && (who.cable >= 0 || who.one == ground || who.other == ground))
      return out_.error(entry_.place, "overlapping: only two bodies that a joint connected can pass through each other",
                        "leave out this contact");
    fields_.finish();
    if (errors == out_.errors() && who.pair >= 0) forest.overlapping.push_back(who.pair);
  }

  void read_point(const SteppedContact& point, std::vector<SteppedContact>& points) {
    constexpr double rounding = 1e-6;
    if (!(std::fabs(norm(point.normal) - 1) < rounding))
      return out_.error(fields_.place_of("normal"), "normal: its length is not 1", remedy);
    if (dot(point.force, point.normal) < -rounding * norm(point.force))
      return out_.error(fields_.place_of("force"), "force: contacts press, and this one pulls", remedy);
    for (const SteppedContact& other : points)
      if (other.pair == point.pair && other.id == point.id)
        return out_.error(entry_.place, "the same contact is there twice", remedy);
    points.push_back(point);
  }

  Vec3 vector(const char* key, bool required) {
    if (required) fields_.require(key, remedy);
    const std::vector<double> x = fields_.reals(key, 3);
    return x.empty() ? Vec3{} : Vec3{x[0], x[1], x[2]};
  }

  BodyId body(const char* key) {
    const Value* const value = fields_.require(key, remedy);
    const auto name = value != nullptr ? read_string(*value, key, out_) : std::nullopt;
    if (!name || *name == "ground") return ground;
    return joints_.body_named(*name, value->place).value_or(ground);
  }

  Who read_who(bool overlapping) {
    const std::size_t errors = out_.errors();
    Who who;
    who.one = body("one"), who.other = body("other");
    if (const auto name = fields_.string("cable")) {
      if (model_.has_spring(*name)) who.cable = model_.spring(*name).index;
      if (who.cable < 0 || !model_.springs()[static_cast<std::size_t>(who.cable)].inextensible)
        out_.error(fields_.place_of("cable"), "there is no cable " + in_quotes(*name), remedy);
      else
        who.pair = pair_of_cable(who.cable);
      return who;
    }
    const std::vector<double> shapes =
        fields_.require("shapes", remedy) != nullptr ? fields_.reals("shapes", 2) : std::vector<double>();
    if (!overlapping) fields_.require("feature", remedy);
    const auto feature = fields_.string("feature");
    if (shapes.size() != 2 || errors != out_.errors()) return who;  // reported
    const int first = shapes_.collider_of(who.one, shapes[0]), second = shapes_.collider_of(who.other, shapes[1]);
    const auto is_plane = [&](int number) { return collider(model_, number).plane; };
    if (first < 0 || second < 0)
      out_.error(
          fields_.place_of("shapes"),
          "shapes: " + in_quotes(model_.body_name(first < 0 ? who.one : who.other)) + " has no collision shape of that number",
          remedy);
    else if (who.one == who.other || (is_plane(first) && is_plane(second)))
      out_.error(fields_.place_of("one"), "one, other: a contact is between two bodies, or a body and the ground", remedy);
    else
      who.pair = pair_of_colliders(model_, first, second);
    if (!feature) return who;
    const char* const end = feature->data() + feature->size();
    if (const auto [stop, error] = std::from_chars(feature->data(), end, who.id); error != std::errc{} || stop != end)
      out_.error(fields_.place_of("feature"), "feature: expected a whole number in quotes", remedy);
    return who;
  }

  void read_closed(Contact& closed, bool stepped) {
    closed.direction = vector("direction", false);
    closed.keeps_direction = fields_.real("keeps_direction").value_or(0);
    closed.settles = fields_.real("settles").value_or(-1);
    if (!stepped) fields_.require("state", remedy);
    const auto state = fields_.string("state");
    if (!state) return;
    const auto known = std::find(states.begin(), states.end(), *state);
    if (known == states.end())
      return out_.error(fields_.place_of("state"), "state: expected smooth, stick or slip, found " + in_quotes(*state));
    closed.mode = static_cast<Contact::Mode>(known - states.begin());
    if (closed.mode == Contact::Mode::slip && !(std::fabs(norm(closed.direction) - 1) < 1e-9))
      out_.error(fields_.place_of("direction"), "direction: its length is not 1");
    if (!(closed.keeps_direction >= 0)) out_.error(fields_.place_of("keeps_direction"), "keeps_direction: must not be negative");
  }

  const Value& entry_;
  const Model& model_;
  const Shapes& shapes_;
  JointReader& joints_;
  Diagnostics& out_;
  Fields fields_;
};

}  // namespace

void write_contacts(JsonWriter& json, const World& world, const SteppingState& stepping) {
  const Model& model = world.model();
  const Shapes shapes(model);
  json.begin_array();
  const std::vector<ContactPoint> points = world.contacts();
  std::size_t next = 0;  // cables have no points
  for (const Contact& contact : world.tree().contacts()) {
    json.begin_object();
    if (contact.cable >= 0) {
      write_touching(json, model, shapes, {{contact.a}, {contact.b}, contact.pair, contact.cable, contact.id});
      write_closed(json, contact);
    } else {
      const ContactPoint& point = points[next++];
      write_touching(json, model, shapes, {point.one, point.other, contact.pair, -1, contact.id});
      write_closed(json, contact);
      write_point(json, point);
    }
    json.end_object();
  }
  for (const Contact& contact : world.constraints().former_contacts) {
    ContactPoint shown{{contact.a}, {contact.b}, {}, {}, {}, {}};
    if (contact.cable < 0) shown = in_order(shown);
    json.begin_object();
    write_touching(json, model, shapes, {shown.one, shown.other, contact.pair, contact.cable, contact.id});
    json.member("former", true);
    write_closed(json, contact);
    json.end_object();
  }
  for (const SteppedContact& point : stepping.points) {
    if (point.joint >= 0) continue;  // a stop, which is with its joint
    ContactPoint shown{{point.a}, {point.b}, point.point, point.normal, point.force, point.slip};
    shown.moment = point.moment;
    if (point.cable < 0) shown = in_order(shown);
    json.begin_object();
    write_touching(json, model, shapes, {shown.one, shown.other, point.pair, point.cable, point.id});
    json.member("stepped", true);
    if (stepping.released) json.member("released", true);
    write_point(json, shown);
    json.end_object();
  }
  constexpr int stride = static_cast<int>(most_colliders);
  for (const int pair : world.constraints().overlapping) {
    json.begin_object();
    write_who(json, model, shapes, {collider(model, pair / stride).body, collider(model, pair % stride).body, pair});
    json.member("overlapping", true).end_object();
  }
  json.end_array();
}

void read_contacts(const Value& list, const Model& model, JointReader& joints, Forest& forest, SteppingState& stepping,
                   Diagnostics& out) {
  const Shapes shapes(model);
  for (const Value& entry : read_list(list, "contacts", out))
    ContactReader(entry, model, shapes, joints, out).read(forest, stepping);
  std::ranges::sort(forest.overlapping);
}

namespace {

// Bodies by name, and those of the last event as a list.
struct SteppingWriter : MemberWriter {
  SteppingWriter(JsonWriter& json, const World& world) : MemberWriter(json, world.model()), world_(world) {}
  using MemberWriter::operator();
  void operator()(const char* key, const std::vector<SteppedBody>& bodies, const Field&) {
    json_.key(key).begin_object();
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      if (bodies[b] == SteppedBody{} || !world_.alive({static_cast<int>(b)})) continue;
      json_.key(model_.bodies()[b].name).begin_object();
      describe(*this, bodies[b]);
      json_.end_object();
    }
    json_.end_object();
  }
  void operator()(const char* key, const std::array<std::string, 2>& last, const Field&) {
    if (!last[0].empty()) json_.key(key).begin_array().value(last[0]).value(last[1]).end_array();
  }

 private:
  const World& world_;
};

struct SteppingReader : MemberReader {
  SteppingReader(Fields& fields, const Model& model, JointReader& joints, Diagnostics& out)
      : MemberReader(fields), model_(model), joints_(joints), out_(out) {}
  using MemberReader::operator();
  void operator()(const char* key, std::vector<SteppedBody>& all, const Field&) {
    const Value* const bodies = fields_.find(key);
    if (bodies == nullptr) return;
    for (const Value::Entry& entry : read_table(*bodies, key, out_)) {
      Fields of_body(entry.value, "body " + in_quotes(entry.key), out_, "");
      const auto body = joints_.body_named(entry.key, entry.place);
      SteppedBody state;
      MemberReader members(of_body);
      describe(members, state);
      of_body.finish();
      if (!body) continue;
      all.resize(static_cast<std::size_t>(model_.size()));
      all[static_cast<std::size_t>(body->index)] = state;
    }
  }
  void operator()(const char* key, std::array<std::string, 2>& bodies, const Field&) {
    const Value* const last = fields_.find(key);
    if (last == nullptr) return;
    const Value::Array& pair = read_list(*last, key, out_);
    if (pair.size() != 2) return out_.error(last->place, "last: expected the names of two bodies");
    for (std::size_t i = 0; i < 2; ++i) bodies[i] = read_string(pair[i], key, out_).value_or("");
  }

 private:
  const Model& model_;
  JointReader& joints_;
  Diagnostics& out_;
};

}  // namespace

void write_stepping(JsonWriter& json, const World& world, const SteppingState& stepping) {
  json.begin_object();
  SteppingWriter members(json, world);
  describe_in_documents(members, stepping);
  json.end_object();
}

void read_stepping(const Value& value, const Model& model, JointReader& joints, SteppingState& stepping, Diagnostics& out) {
  Fields fields(value, "contacts", out, "");
  SteppingReader members(fields, model, joints, out);
  describe_in_documents(members, stepping);
  stepping.on = stepping.on && std::ranges::any_of(stepping.bodies, &SteppedBody::on), stepping.all = stepping.all && stepping.on;
  fields.finish();
}

}  // namespace momentree::io
