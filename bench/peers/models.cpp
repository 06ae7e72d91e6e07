// The models of the evaluations: random, or read from files of `momentree bench MODEL`.
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include <Eigen/Eigenvalues>

#include "evaluation.hpp"
#include "figure.hpp"

namespace peers {
namespace {

EvaluationModel tree(const char* name, int bodies, bool planar, bool binary) {
  Draw draw(static_cast<unsigned>(bodies));
  EvaluationModel model{std::string(name) + " " + std::to_string(bodies), {}};
  for (int i = 0; i < bodies; ++i) model.links.push_back(pin(draw, i, binary ? (i + 1) / 2 - 1 : i - 1, planar));
  return model;
}

/// A free pelvis and 30 revolute joints along the axes of a standing body: two legs of 6, waist and neck of 2, two arms of 7.
EvaluationModel humanoid() {
  Figure figure(31);
  const double side = 0.1, leg = 0.4, arm = 0.27;
  const int pelvis = figure.add(-1, 'z', Vector3d::Zero(), true);
  for (const double s : {side, -side}) figure.limb(pelvis, "zxyyyx", {{0, s, -0.05}, {}, {}, {0, 0, -leg}, {0, 0, -leg}, {}});
  const int chest = figure.limb(pelvis, "zy", {{0, 0, 0.1}, {}});
  for (const double s : {2 * side, -2 * side})
    figure.limb(chest, "yxzyzyx", {{0, s, 0.3}, {}, {}, {0, 0, -arm}, {}, {0, 0, -arm}, {}});
  figure.limb(chest, "zy", {{0, 0, 0.4}, {}});
  return {"humanoid " + std::to_string(figure.links.size() - 1) + "+6", figure.links};
}

std::vector<EvaluationModel> drawn() {
  return {tree("planar chain", 1, true, false),     tree("planar chain", 10, true, false),
          tree("planar chain", 100, true, false),   tree("planar chain", 1000, true, false),
          tree("spatial chain", 1, false, false),   tree("spatial chain", 7, false, false),
          tree("spatial chain", 100, false, false), tree("spatial chain", 1000, false, false),
          tree("binary tree", 63, false, true),     humanoid()};
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
