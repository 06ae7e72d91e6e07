#pragma once
// A MuJoCo model made from links.
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <sstream>

#include <mujoco/mujoco.h>

#include "experiment.hpp"

namespace peers {

inline std::string text(const Vector3d& a) {
  std::ostringstream out;
  out.precision(17);
  out << a.x() << ' ' << a.y() << ' ' << a.z();
  return out.str();
}
inline std::string text(const Eigen::Quaterniond& q) {
  std::ostringstream out;
  out.precision(17);
  out << q.w() << ' ' << q.x() << ' ' << q.y() << ' ' << q.z();
  return out.str();
}
inline std::string pose(const Matrix3d& R, const Vector3d& p) {
  return "pos='" + text(p) + "' quat='" + text(Eigen::Quaterniond(R)) + '\'';
}

/// A compiled model of the links. A locked revolute joint is a body without a joint.
class Model {
 public:
  Model(const std::vector<Link>& links, int fixed, const std::string& equality) : files(1) {
    files[0].precision(17);
    files[0] << "<mujoco><compiler angle='radian'/><option timestep='1e-3' integrator='RK4' gravity='0 0 0'/><worldbody>";
    for (int i = 0; i < static_cast<int>(links.size()); ++i) {
      if (links[i].parent < 0) write(0, links, i, fixed);
    }
    files[0] << "</worldbody><equality>" << equality << "</equality></mujoco>";
    load();
    data = mj_makeData(model);
  }
  ~Model() { mj_deleteData(data), mj_deleteModel(model); }
  Model(const Model&) = delete;
  Model& operator=(const Model&) = delete;

  int body(const Link& link) const { return mj_name2id(model, mjOBJ_BODY, link.name.c_str()); }
  int joint(const Link& link) const { return mj_name2id(model, mjOBJ_JOINT, link.name.c_str()); }
  mjtNum* q(const Link& link) const { return data->qpos + model->jnt_qposadr[joint(link)]; }
  mjtNum* v(const Link& link) const { return data->qvel + model->jnt_dofadr[joint(link)]; }

  mjModel* model = nullptr;
  mjData* data = nullptr;

 private:
  void write(int file, const std::vector<Link>& links, int i, int fixed) {
    const Link& link = links[i];
    files[file] << "<body name='" << link.name << "' " << pose(link.turn, link.at) << "><inertial pos='" << text(link.com)
                << "' mass='" << link.mass << "' quat='" << text(Eigen::Quaterniond(link.axes)) << "' diaginertia='"
                << text(link.inertia) << "'/>";
    if (link.free) files[file] << "<freejoint name='" << link.name << "'/>";
    if (!link.free && i != fixed)
      files[file] << "<joint name='" << link.name << "' type='" << (link.slides ? "slide" : "hinge") << "' axis='0 0 1'/>";
    for (int k = i + 1; k < static_cast<int>(links.size()); ++k) {
      if (links[k].parent != i) continue;
      if (k % 50 > 0) {
        write(file, links, k, fixed);
        continue;
      }
      const int next = static_cast<int>(files.size());  // a file of MJCF may nest fewer than a hundred elements
      files[file] << "<include file='" << next << ".xml'/>";
      files.emplace_back().precision(17);
      files[next] << "<mujocoinclude>";
      write(next, links, k, fixed);
      files[next] << "</mujocoinclude>";
    }
    files[file] << "</body>";
  }
  void load() {
    const auto vfs = std::make_unique<mjVFS>();
    mj_defaultVFS(vfs.get());
    for (std::size_t i = 0; i < files.size(); ++i) {
      const std::string xml = files[i].str();
      mj_makeEmptyFileVFS(vfs.get(), (std::to_string(i) + ".xml").c_str(), static_cast<int>(xml.size()));
      std::memcpy(vfs->filedata[i], xml.data(), xml.size());
    }
    char error[1000] = "";
    model = mj_loadXML("0.xml", vfs.get(), error, sizeof error);
    mj_deleteVFS(vfs.get());
    if (model == nullptr) std::fprintf(stderr, "%s\n", error), std::exit(1);
  }
  std::vector<std::ostringstream> files;
};

}  // namespace peers
