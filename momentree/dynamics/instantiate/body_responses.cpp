// Single steps of the passes in solve.ipp, for unit wrenches.
#include <momentree/dynamics/contacts/body_response.hpp>
#include <momentree/dynamics/wrench_inboard.hpp>
#include <momentree/joint/dispatch.hpp>

namespace momentree {

namespace {

Force<double> unit_wrench(std::size_t c) {
  double of[6] = {};
  of[c] = 1;
  return {{of[0], of[1], of[2]}, {of[3], of[4], of[5]}};
}

template <class K>
void find_response(UncheckedTree tree, const double* q, const Workspace<double>& workspace, int b, unsigned flags,
                   BodyResponse& all) {
  if constexpr (K::rigid) {
    for (std::size_t c = 0; c < 6; ++c) all.carried[c] = unit_wrench(c);
  } else {
    const LinkConstants& link = tree.link(b);
    const JointState<double> joint = joint_state(tree, q, workspace, b);
    const auto& record = workspace.template record<K>(tree, b);
    for (std::size_t c = 0; c < 6; ++c) {
      const double none[6] = {};
      Force<double> W = -1.0 * unit_wrench(c);
      K::template reduce_wrench<double>(link, joint, record, none, W, all.own[c].data());  // (51)
      wrench_inboard<K>(link, joint, record, flags, W);                                    // (45)
      all.carried[c] = -1.0 * W;
      K::joint_acceleration(record, Motion<double>{}, all.own[c].data());
      all.moves[c] = K::template spatial_velocity<double>(link, joint, {}, all.own[c].data());  // (39)
      const Force<double> unit = unit_wrench(c);
      Motion<double> given{unit.l, unit.h};
      if (K::rotates_about_z && (flags & node::aligned) != 0)
        K::template cached_transform<true, double>(link, joint, record).outboard(given);
      else
        K::template cached_transform<false, double>(link, joint, record).outboard(given);
      K::joint_acceleration(record, given, all.given[c].data());  // (47)
    }
  }
}

}  // namespace

void find_body_responses(const Tree& tree, const double* q, const Workspace<double>& workspace, int begin, int end,
                         BodyResponse* responses) noexcept {
  for (int place = begin; place < end; ++place) {
    const int b = tree.order()[static_cast<std::size_t>(place)];
    const unsigned flags = tree.tables().node_flags[static_cast<std::size_t>(place)];
    BodyResponse& all = responses[place - begin] = {};
    dispatch_kernels(tree.kind(b), tree.variant(b),
                     [&](auto tag) { find_response<typename decltype(tag)::type>(tree, q, workspace, b, flags, all); });
  }
}

}  // namespace momentree
