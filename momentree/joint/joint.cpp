#include <momentree/joint/joint.hpp>

#include <iterator>
#include <utility>

#include <momentree/base/check.hpp>
#include <momentree/joint/kinds.hpp>
#include <momentree/joint/link_constants.hpp>

namespace momentree {

namespace {
constexpr KindInfo every_kind[] = {
#define MOMENTREE_KIND(name, Type) Type::info,
    MOMENTREE_KINDS(MOMENTREE_KIND)
#undef MOMENTREE_KIND
};
}  // namespace

const std::vector<KindInfo>& all_kinds() {
  static const std::vector<KindInfo> kinds(std::begin(every_kind), std::end(every_kind));
  return kinds;
}

const KindInfo& info(Kind kind) {
  MT_REQUIRE(static_cast<std::size_t>(kind) < std::size(every_kind), "one of the kinds of joint");
  return every_kind[static_cast<std::size_t>(kind)];
}

const KindInfo* find_kind(std::string_view name) {
  for (const KindInfo& k : all_kinds())
    if (name == k.name) return &k;
  return nullptr;
}

bool JointParameters::any() const {
  return damping.any() || stiffness.any() || armature.any() || effort.any() || !rest.empty() || limits.any() || friction.any() ||
         strength.any() || drive != nullptr;
}

std::shared_ptr<const JointDrive> effort_drive(std::vector<Signal> effort) {
  JointDrive drive;
  drive.effort = std::move(effort);
  return std::make_shared<const JointDrive>(std::move(drive));
}

std::shared_ptr<const JointDrive> pd_drive(JointDrive::Pd pd) {
  JointDrive drive;
  drive.pd = std::move(pd);
  return std::make_shared<const JointDrive>(std::move(drive));
}

std::shared_ptr<const JointDrive> motion_drive(const Signal& position) {
  JointDrive drive;
  drive.motion.emplace_back(position);
  return std::make_shared<const JointDrive>(std::move(drive));
}

void begin_motion(std::shared_ptr<const JointDrive>& drive, double position, double t) {
  if (drive == nullptr || !drive->moves() || !drive->motion[0].signal().from_here()) return;
  JointDrive begun = *drive;
  begun.motion[0] = Curve(drive->motion[0].signal().begun_at(position, t));
  drive = std::make_shared<const JointDrive>(std::move(begun));
}

Mat3 tilt_rotation(const LinkConstants& k) {
  const Mat3 Rb{k.cos_b, -k.sin_b, 0, k.sin_b, k.cos_b, 0, 0, 0, 1};
  const Mat3 Ra{1, 0, 0, 0, k.cos_a, -k.sin_a, 0, k.sin_a, k.cos_a};
  return Rb * Ra;
}

void find_rotation(LinkConstants& k) {
  k.cs_a = k.cos_a * k.sin_a, k.ss_a = k.sin_a * k.sin_a;
  k.R0 = placement_rotation(k);
}
Mat3 placement_rotation(const LinkConstants& k) {
  return tilt_rotation(k) * Mat3{k.cos_0, -k.sin_0, 0, k.sin_0, k.cos_0, 0, 0, 0, 1};
}

}  // namespace momentree
