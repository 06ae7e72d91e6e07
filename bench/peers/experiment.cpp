#include "experiment.hpp"

#include <cmath>
#include <numeric>

#include "draw.hpp"

namespace peers {
namespace {

Matrix3d turned(const Vector3d& by) { return Eigen::AngleAxisd(by.norm(), by.normalized()).toRotationMatrix(); }

Link piece(Draw& draw, std::string name, int parent, double mass, double length) {
  Link link;
  link.name = std::move(name);
  link.parent = parent;
  link.free = false;
  link.mass = mass * draw.between(0.7, 1.3);
  link.com = Vector3d(0.5 * length, 0, 0) + draw.within(0.1 * length);
  const double i = link.mass * length * length / 12, x = draw.between(0.3, 0.6), y = draw.between(0.8, 1);
  link.inertia = {i * x, i * y, i};
  return link;
}

Link pin(Draw& draw, std::string name, int parent, double mass, double length, const Vector3d& at) {
  Link link = piece(draw, std::move(name), parent, mass, length);
  link.at = at;
  link.turn = turned(draw.within(0.8));
  link.angle = draw.between(-0.6, 0.6);
  link.rate = draw.between(-1.5, 1.5);
  return link;
}

Link root(Draw& draw, std::string name, double mass, double size, const Vector3d& at) {
  Link link = piece(draw, std::move(name), -1, mass, size);
  link.free = true;
  link.at = at;
  link.turn = turned(draw.within(1.0));
  link.linear = draw.within(0.5);
  link.angular = draw.within(0.8);
  return link;
}

std::vector<int> all(const std::vector<Link>& links) {
  std::vector<int> every(links.size());
  std::iota(every.begin(), every.end(), 0);
  return every;
}

/// A grounded, fast-moving chain of revolute joints in general position; cut in the middle.
Experiment cut_chain(int bodies) {
  Draw draw(static_cast<unsigned>(bodies));
  Experiment e{"break " + std::to_string(bodies), {}, Change::cut, bodies / 2, -1, {}};
  for (int i = 0; i < bodies; ++i) {
    e.links.push_back(pin(draw, "b" + std::to_string(i), i - 1, 0.5, 0.2, i > 0 ? Vector3d(0.2, 0, 0) : Vector3d::Zero()));
  }
  e.judged = subtree(e.links, e.body);
  return e;
}

/// A floating hull with an arm of four revolute joints and a panel on a fifth; the arm's elbow jams.
Experiment lock_elbow() {
  Draw draw(7);
  Experiment e{"lock", {}, Change::lock, 2, -1, {}};
  e.links.push_back(root(draw, "hull", 8, 0.6, {0.3, -0.2, 0.5}));
  for (int i = 1; i <= 4; ++i) {
    e.links.push_back(pin(draw, "arm" + std::to_string(i), i - 1, 1.5, 0.4, {i > 1 ? 0.4 : 0.6, 0, 0}));
  }
  e.links.push_back(pin(draw, "panel", 0, 1, 0.8, {0, 0.3, 0}));
  e.judged = all(e.links);
  return e;
}

/// A tug with an arm of three revolute joints welds its hand to a tumbling satellite that carries a panel on a revolute joint.
Experiment capture() {
  Draw draw(11);
  Experiment e{"capture", {}, Change::capture, 4, 3, {}};
  e.links.push_back(root(draw, "tug", 10, 0.6, {0, 0, 0}));
  for (int i = 1; i <= 3; ++i) {
    e.links.push_back(pin(draw, "arm" + std::to_string(i), i - 1, 1.5, 0.4, {i > 1 ? 0.4 : 0.6, 0, 0}));
  }
  e.links.push_back(root(draw, "satellite", 6, 0.5, {1.6, 0.5, 0.2}));
  e.links.push_back(pin(draw, "panel", 4, 1, 0.8, {0, 0.3, 0}));
  e.judged = all(e.links);
  return e;
}

}  // namespace

std::vector<Experiment> experiments() { return {cut_chain(10), cut_chain(100), lock_elbow(), capture()}; }

std::vector<int> subtree(const std::vector<Link>& links, int body) {
  std::vector<bool> in(links.size());
  std::vector<int> found;
  for (int i = body; i < static_cast<int>(links.size()); ++i) {
    const int parent = links[i].parent;
    in[i] = i == body || (parent >= 0 && in[parent]);
    if (in[i]) found.push_back(i);
  }
  return found;
}

std::vector<Motion> start(const Experiment& experiment) {
  std::vector<Motion> motions;
  for (const Link& link : experiment.links) {
    if (link.free) {
      motions.push_back({link.turn, link.at, link.linear, link.angular});
      continue;
    }
    const Motion base = link.parent < 0 ? Motion{Matrix3d::Identity(), Vector3d::Zero(), Vector3d::Zero(), Vector3d::Zero()}
                                        : motions[link.parent];
    const Vector3d arm = base.R * link.at;
    const Matrix3d R = base.R * link.turn * Eigen::AngleAxisd(link.angle, Vector3d::UnitZ()).toRotationMatrix();
    motions.push_back({R, base.p + arm, base.v + base.w.cross(arm), base.w + link.rate * R.col(2)});
  }
  return motions;
}

EnergyLedger ledger(const Experiment& experiment, const std::vector<Motion>& motions) {
  EnergyLedger sum;
  const auto spin = [&](std::size_t i) -> Vector3d {
    const Matrix3d& R = motions[i].R;
    return R * experiment.links[i].inertia.cwiseProduct(R.transpose() * motions[i].w);
  };
  for (const int i : experiment.judged) {
    const Link& link = experiment.links[i];
    const Vector3d l = link.mass * centre_velocity(link, motions[i]);
    sum.linear += l;
    sum.angular += centre(link, motions[i]).cross(l) + spin(i);
  }
  for (std::size_t i = 0; i < motions.size(); ++i) {
    sum.kinetic += 0.5 * experiment.links[i].mass * centre_velocity(experiment.links[i], motions[i]).squaredNorm();
    sum.kinetic += 0.5 * motions[i].w.dot(spin(i));
  }
  return sum;
}

}  // namespace peers
