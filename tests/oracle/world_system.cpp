// The oracle's input from a world: numbers and topology, no computed results.
#include <momentree/simulate/world/world.hpp>
#include <tests/oracle/oracle.hpp>

namespace momentree::oracle {

System system_of(const World& world) {
  System system;
  system.gravity = {{world.model().gravity().x, world.model().gravity().y, world.model().gravity().z}};
  for (int k = 0; k < world.model().size(); ++k) {
    const BodySpec& body = world.model()[BodyId{k}];
    const JointView joint = world.joint({k});
    Link link{joint.parent.index, {}, joint.at, joint.child_at, body.mass, body.com, body.inertia};
    link.joint.kind = joint.kind;
    link.joint.axis = joint.axis;
    link.joint.axis2 = joint.axis2;
    link.joint.pitch = joint.pitch;
    if (joint.parameters) link.joint.parameters = *joint.parameters;
    system.links.push_back(link);
  }
  number(system);
  return system;
}

}  // namespace momentree::oracle
