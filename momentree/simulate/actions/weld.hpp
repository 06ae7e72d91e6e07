#pragma once
// Joins a body rigidly to another mechanism or to the ground in their present poses: a perfectly inelastic impact.
#include <momentree/simulate/actions/attach.hpp>

namespace momentree::actions {

struct Weld : Attach {
  std::string_view key() const override { return "weld"; }
  const char* summary() const override { return "Joins a body rigidly to another, or to the ground"; }
  const char* hint() const override { return R"(for example weld = { body = "satellite/hull", to = "tug/gripper" })"; }
  void arguments(const ArgumentVisitor& visit) override {
    visit({"body", argument::Body{body}});
    visit({"to", argument::OtherBody{to}});
    visit({"name", argument::MadeJoint{name}});
  }
};

}  // namespace momentree::actions
