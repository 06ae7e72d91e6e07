#pragma once
// A MuJoCo model made from links.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include <mujoco/mujoco.h>

#include "experiment.hpp"

namespace peers {

inline void put(const Vector3d& from, double* to) { std::copy(from.data(), from.data() + 3, to); }
inline void put(const Matrix3d& R, double* to) {
  const Eigen::Quaterniond q(R);
  to[0] = q.w(), to[1] = q.x(), to[2] = q.y(), to[3] = q.z();
}

/// A specification of the links, compiled. Elements have the names of the links.
class Model {
 public:
  /// `fixed`: a link without a joint (-1: none).
  explicit Model(const std::vector<Link>& links, int fixed = -1) : spec(mj_makeSpec()) {
    spec->option.timestep = 1e-3;
    spec->option.integrator = mjINT_RK4;
    spec->option.gravity[2] = 0;
    std::vector<mjsBody*> bodies;
    for (int i = 0; i < static_cast<int>(links.size()); ++i) {
      const Link& link = links[i];
      mjsBody* parent = link.parent < 0 ? mjs_findBody(spec, "world") : bodies[link.parent];
      mjsBody* body = bodies.emplace_back(mjs_addBody(parent, nullptr));
      mjs_setName(body->element, link.name.c_str());
      put(link.turn, body->quat), put(link.at, body->pos);
      body->explicitinertial = true;
      body->mass = link.mass;
      put(link.com, body->ipos), put(link.axes, body->iquat), put(link.inertia, body->inertia);
      if (link.free) mjs_setName(mjs_addFreeJoint(body)->element, link.name.c_str());
      if (link.free || i == fixed) continue;
      mjsJoint* joint = mjs_addJoint(body, nullptr);
      mjs_setName(joint->element, link.name.c_str());
      joint->type = link.slides ? mjJNT_SLIDE : mjJNT_HINGE;
      put(Vector3d(0, 0, 1), joint->axis);
    }
  }
  ~Model() { mj_deleteData(data), mj_deleteModel(model), mj_deleteSpec(spec); }
  Model(const Model&) = delete;
  Model& operator=(const Model&) = delete;

  void compile() {
    model = mj_compile(spec, nullptr);
    require(model != nullptr);
    data = mj_makeData(model);
  }
  /// Keeps the state of joints that exist before and after.
  void recompile() { require(mj_recompile(spec, nullptr, model, data) == 0); }
  void require(bool good) {
    if (!good) std::fprintf(stderr, "%s\n", mjs_getError(spec)), std::exit(1);
  }

  mjsBody* body_spec(const Link& link) { return mjs_findBody(spec, link.name.c_str()); }
  int body(const Link& link) const { return mj_name2id(model, mjOBJ_BODY, link.name.c_str()); }
  int joint(const Link& link) const { return mj_name2id(model, mjOBJ_JOINT, link.name.c_str()); }
  mjtNum* q(const Link& link) const { return data->qpos + model->jnt_qposadr[joint(link)]; }
  mjtNum* v(const Link& link) const { return data->qvel + model->jnt_dofadr[joint(link)]; }
  /// The state of a free link: the linear velocity is in world axes, the angular one in the body's.
  void set(const Link& link, const Motion& motion) const {
    put(motion.p, q(link)), put(motion.R, q(link) + 3);
    put(motion.v, v(link)), put(Vector3d(motion.R.transpose() * motion.w), v(link) + 3);
  }
  Motion read(const Link& link) const {
    const int id = body(link);
    mjtNum v[6];
    mj_objectVelocity(model, data, mjOBJ_XBODY, id, v, 0);
    Matrix3d R;
    for (int k = 0; k < 9; ++k) R(k / 3, k % 3) = data->xmat[9 * id + k];
    return {R, Vector3d(data->xpos + 3 * id), Vector3d(v + 3), Vector3d(v)};
  }

  mjSpec* spec;
  mjModel* model = nullptr;
  mjData* data = nullptr;
};

}  // namespace peers
