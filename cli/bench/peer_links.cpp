#include <cli/bench/peer_links.hpp>

#include <vector>

#include <cli/text.hpp>
#include <momentree/base/error.hpp>
#include <momentree/joint/screw_kernels.hpp>
#include <momentree/math/point_inertia.hpp>

namespace momentree::cli {

namespace {

struct Link {
  int parent = -1;
  const char* joint = "";
  Mat3 rotation{};
  Vec3 at{};
  double mass = 0;
  Vec3 first_moment{};  // about the frame's origin
  Sym3 inertia{};       // about the same
};

/// The pose of a body's own frame in that of a link.
struct Place {
  int link = -1;  ///< −1: the ground
  Mat3 R = identity3<double>();
  Vec3 r{};
};
Place operator*(const Place& a, const Pose& b) { return {a.link, a.R * rotation_matrix(b.rotation), a.r + a.R * b.position}; }

class Links {
 public:
  explicit Links(const Model& model) {
    for (const BodySpec& body : model.bodies()) add(body);
  }
  const std::vector<Link>& all() const { return links_; }

 private:
  void add(const BodySpec& body) {
    const Place outer = (body.parent.index < 0 ? Place{} : places_[static_cast<std::size_t>(body.parent.index)]) * body.at;
    places_.push_back(body.joint.kind == Kind::weld ? outer * inverse(body.child_at) : moving(body, outer));
    const Place& place = places_.back();
    if (place.link < 0) return;
    Link& link = links_[static_cast<std::size_t>(place.link)];
    const Vec3 com = place.r + place.R * body.com;
    link.mass += body.mass;
    link.first_moment += body.mass * com;
    link.inertia = link.inertia + rotate(place.R, body.inertia) + point_inertia(body.mass, com);
  }

  Place moving(const BodySpec& body, const Place& outer) {
    const int number = static_cast<int>(links_.size());
    Mat3 axes = identity3<double>();
    if (body.joint.kind == Kind::free) {
      if (number > 0) refuse(body, "has a free joint, but is not the first moving body");
    } else if (!links_.empty() && links_[0].joint[0] == 'f' && outer.link < 0) {
      refuse(body, "is attached to the ground, in addition to a floating body");
    } else if (body.joint.kind == Kind::revolute || body.joint.kind == Kind::prismatic) {
      axes = frame_with_z(body.joint.axis);
    } else {
      refuse(body, std::string("has a ") + info(body.joint.kind).name + " joint");
    }
    const Kind kind = body.joint.kind;
    links_.push_back({outer.link,
                      kind == Kind::free       ? "free"
                      : kind == Kind::revolute ? "revolute"
                                               : "prismatic",
                      outer.R * axes, outer.r, 0, Vec3{}, Sym3{}});
    return Place{number, transpose(axes), Vec3{}} * inverse(body.child_at);
  }

  [[noreturn]] static void refuse(const BodySpec& body, const std::string& what) {
    throw_error({"other engines do not support this model: " + body.name + " " + what, "",
                 "use revolute, prismatic and weld joints, grounded or on one free body, or leave out --peers"});
  }

  std::vector<Link> links_;
  std::vector<Place> places_;  // by body
};

}  // namespace

std::string peer_links(const std::string& name, const Model& model) {
  std::string text = name + '\n';
  const auto add = [&text](double x) { text += format(" %.17g", x); };
  const Links links(model);
  for (const Link& link : links.all()) {
    const Vec3 com = link.mass > 0 ? (1 / link.mass) * link.first_moment : Vec3{};
    const Sym3 inertia = link.inertia + point_inertia(-link.mass, com);
    text += format("%d %s", link.parent, link.joint);
    const Mat3& R = link.rotation;
    for (const double x :
         {R.xx,      R.xy,      R.xz,  R.yx,  R.yy,  R.yz,       R.zx,       R.zy,       R.zz,       link.at.x,  link.at.y,
          link.at.z, link.mass, com.x, com.y, com.z, inertia.xx, inertia.yy, inertia.zz, inertia.xy, inertia.xz, inertia.yz})
      add(x);
    text += '\n';
  }
  return text;
}

}  // namespace momentree::cli
