// The models of the evaluations: random, or read from files of `momentree bench MODEL`.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include <Eigen/Eigenvalues>

#include "draw.hpp"
#include "evaluation.hpp"

namespace peers {
namespace {

Link pin(Draw& draw, int number, int parent, bool planar) {
  Link link;
  link.name = "b" + std::to_string(number);
  link.parent = parent;
  link.mass = draw.between(0.5, 1.5);
  link.at = parent < 0 ? Vector3d::Zero() : Vector3d(0.2, 0, 0);
  if (planar) {
    link.com = {0.1, 0, 0};
    if (parent < 0) link.turn = Eigen::AngleAxisd(1.5707963267948966, Vector3d::UnitX()).toRotationMatrix();  // upright
  } else {
    const Vector3d by = draw.within(1.2);
    link.turn = Eigen::AngleAxisd(by.norm(), by.normalized()).toRotationMatrix();
    link.com = Vector3d(0.1, 0, 0) + draw.within(0.03);
  }
  link.inertia = link.mass * 0.04 * Vector3d(0.2, 0.7, 0.8);
  link.angle = draw.between(-0.6, 0.6);
  link.rate = draw.between(-1, 1);
  return link;
}

EvaluationModel tree(const char* name, int bodies, bool planar, bool binary) {
  Draw draw(static_cast<unsigned>(bodies));
  EvaluationModel model{std::string(name) + " " + std::to_string(bodies), {}};
  for (int i = 0; i < bodies; ++i) model.links.push_back(pin(draw, i, binary ? (i + 1) / 2 - 1 : i - 1, planar));
  return model;
}

/// A free pelvis and 30 revolute joints along the axes of a standing body: two legs of 6, waist and neck of 2, two arms of 7.
class Humanoid {
 public:
  EvaluationModel model() {
    const double side = 0.1, leg = 0.4, arm = 0.27;
    const int pelvis = add(-1, 'z', Vector3d::Zero());
    for (const double s : {side, -side}) limb(pelvis, "zxyyyx", {{0, s, -0.05}, {}, {}, {0, 0, -leg}, {0, 0, -leg}, {}});
    const int chest = limb(pelvis, "zy", {{0, 0, 0.1}, {}});
    for (const double s : {2 * side, -2 * side})
      limb(chest, "yxzyzyx", {{0, s, 0.3}, {}, {}, {0, 0, -arm}, {}, {0, 0, -arm}, {}});
    limb(chest, "zy", {{0, 0, 0.4}, {}});
    return {"humanoid " + std::to_string(links_.size() - 1) + "+6", links_};
  }

 private:
  struct Offset {
    double x = 0, y = 0, z = 0;
  };
  int limb(int last, const char* axes, std::initializer_list<Offset> offsets) {
    for (const Offset& offset : offsets) last = add(last, *axes++, {offset.x, offset.y, offset.z});
    return last;
  }
  /// Axis and offset from the parent's origin, in world axes at zero angles.
  int add(int parent, char axis, const Vector3d& offset) {
    const int number = static_cast<int>(links_.size());
    Link link = pin(draw_, number, parent, false);
    const double right = 1.5707963267948966;
    Matrix3d stands = Matrix3d::Identity();
    if (axis == 'x') stands = Eigen::AngleAxisd(right, Vector3d::UnitY()).toRotationMatrix();
    if (axis == 'y') stands = Eigen::AngleAxisd(-right, Vector3d::UnitX()).toRotationMatrix();
    const Matrix3d parent_stands = parent < 0 ? Matrix3d::Identity() : stands_[parent];
    link.turn = parent_stands.transpose() * stands;
    for (double& x : link.turn.reshaped()) x = std::round(x);  // quarter turns
    link.at = parent_stands.transpose() * offset;
    if (parent < 0) {
      link.free = true;
      link.turn = Eigen::AngleAxisd(0.7, Vector3d(0.6, 0, 0.8)).toRotationMatrix();
      link.at = {0.1, 0.2, 1};
      link.linear = {0.1, -0.2, 0.3}, link.angular = {0.4, -0.5, 0.6};
    }
    links_.push_back(link);
    stands_.push_back(stands);
    return number;
  }
  Draw draw_{31};
  std::vector<Link> links_;
  std::vector<Matrix3d> stands_;
};

std::vector<EvaluationModel> drawn() {
  return {tree("planar chain", 1, true, false),     tree("planar chain", 10, true, false),
          tree("planar chain", 100, true, false),   tree("planar chain", 1000, true, false),
          tree("spatial chain", 1, false, false),   tree("spatial chain", 7, false, false),
          tree("spatial chain", 100, false, false), tree("spatial chain", 1000, false, false),
          tree("binary tree", 63, false, true),     Humanoid().model()};
}

/// A line of the file: see cli/bench/peer_links.hpp. Its initial state is random.
Link read_link(std::istringstream& line, int number, Draw& draw) {
  Link link;
  std::string joint;
  Matrix3d inertia;
  line >> link.parent >> joint;
  for (int i = 0; i < 9; ++i) line >> link.turn(i / 3, i % 3);
  line >> link.at.x() >> link.at.y() >> link.at.z() >> link.mass >> link.com.x() >> link.com.y() >> link.com.z();
  line >> inertia(0, 0) >> inertia(1, 1) >> inertia(2, 2) >> inertia(1, 0) >> inertia(2, 0) >> inertia(2, 1);
  const bool whole = !line.fail() && (joint == "revolute" || joint == "prismatic" || joint == "free") && link.parent < number;
  if (!whole || (joint == "free") != (link.free = joint == "free" && number == 0)) {
    std::fprintf(stderr, "link %d is not valid: %s\n", number, line.str().c_str());
    std::exit(1);
  }
  link.name = "b" + std::to_string(number);
  link.slides = joint == "prismatic";
  const Eigen::SelfAdjointEigenSolver<Matrix3d> principal(inertia);  // of the lower triangle
  link.inertia = principal.eigenvalues().cwiseMax(0);
  link.axes = principal.eigenvectors();
  if (link.axes.determinant() < 0) link.axes.col(0) *= -1;
  link.angle = link.slides ? draw.between(-0.01, 0.01) : draw.between(-0.6, 0.6);
  link.rate = draw.between(-1, 1);
  if (link.free) link.linear = {0.1, -0.2, 0.3}, link.angular = {0.4, -0.5, 0.6};
  return link;
}

EvaluationModel read(const std::string& file) {
  std::ifstream text(file);
  EvaluationModel model;
  if (!std::getline(text, model.name)) std::fprintf(stderr, "%s can't be read\n", file.c_str()), std::exit(1);
  Draw draw(1);
  for (std::string line; std::getline(text, line);) {
    std::istringstream words(line);
    model.links.push_back(read_link(words, static_cast<int>(model.links.size()), draw));
  }
  if (model.links.empty()) std::fprintf(stderr, "%s has no links\n", file.c_str()), std::exit(1);
  return model;
}

}  // namespace

std::vector<EvaluationModel> models(const std::vector<std::string>& files) {
  if (files.empty()) return drawn();
  std::vector<EvaluationModel> all;
  for (const std::string& file : files) all.push_back(read(file));
  return all;
}

}  // namespace peers
