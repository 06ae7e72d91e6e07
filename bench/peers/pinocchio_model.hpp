#pragma once
// A Pinocchio model made from links.
#include <memory>
#include <vector>

#include <pinocchio/algorithm/kinematics.hpp>
#include <pinocchio/multibody.hpp>

#include "experiment.hpp"

namespace peers {

namespace pin = pinocchio;

/// A link that is free has its pose and velocity in q and u, not in the model. A fixed link (-1: none) is part of its parent.
struct Model {
  Model(const std::vector<Link>& links, int fixed = -1) {
    for (int i = 0; i < static_cast<int>(links.size()); ++i) {
      const Link& link = links[i];
      const pin::JointIndex parent = link.parent < 0 ? 0 : numbers[link.parent];
      const pin::SE3 carrier = link.parent < 0 ? pin::SE3::Identity() : frames[link.parent];
      const pin::SE3 place = link.free ? pin::SE3::Identity() : carrier * pin::SE3(link.turn, link.at);
      numbers.push_back(i == fixed    ? parent
                        : link.free   ? model.addJoint(parent, pin::JointModelFreeFlyer(), place, link.name)
                        : link.slides ? model.addJoint(parent, pin::JointModelPZ(), place, link.name)
                                      : model.addJoint(parent, pin::JointModelRZ(), place, link.name));
      frames.push_back(i == fixed ? place : pin::SE3::Identity());
      if (i != fixed) model.addJointFrame(numbers[i]);  // which buildReducedModel expects
      model.appendBodyToJoint(numbers[i], pin::Inertia(link.mass, link.com, inertia_of(link)), frames[i]);
    }
    data = std::make_unique<pin::Data>(model);
    q = Eigen::VectorXd::Zero(model.nq);
    u = Eigen::VectorXd::Zero(model.nv);
  }

  /// Where the joint of a link has its coordinates and velocities.
  int place(int link) const { return model.joints[numbers[link]].idx_q(); }
  int row(int link) const { return model.joints[numbers[link]].idx_v(); }
  /// The state of a free link.
  void put(int link, const Motion& motion) {
    q.segment<3>(place(link)) = motion.p;
    q.segment<4>(place(link) + 3) = Eigen::Quaterniond(motion.R).coeffs();
    u.segment<3>(row(link)) = motion.R.transpose() * motion.v;
    u.segment<3>(row(link) + 3) = motion.R.transpose() * motion.w;
  }
  void put(int link, double angle, double rate) { q[place(link)] = angle, u[row(link)] = rate; }
  /// After pin::forwardKinematics.
  Motion read(int link) const {
    const pin::SE3 pose = data->oMi[numbers[link]] * frames[link];
    const pin::Motion motion = frames[link].actInv(data->v[numbers[link]]);
    return {pose.rotation(), pose.translation(), pose.rotation() * motion.linear(), pose.rotation() * motion.angular()};
  }

  pin::Model model;
  std::unique_ptr<pin::Data> data;
  std::vector<pin::JointIndex> numbers;  // of the joints that carry the links
  std::vector<pin::SE3> frames;          // of the links in those joints
  Eigen::VectorXd q, u;
};

}  // namespace peers
