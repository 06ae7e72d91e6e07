// Events, conditions, actions, forces, springs and couplings.
#include <momentree/scenario/mistakes/keys.hpp>

namespace momentree::io::mistakes {

namespace {

constexpr const char* above_or_below =
    "write the quantity and what it passes: when = { reaction_force = \"arm/elbow\", exceeds = \"4 kN\" }";

constexpr Mistake mistakes_in_events[] = {
    {"[[event]]", "id label", "name", "name = \"snap\""},
    {"[[event]]", "time t instant attime when0", "at", "at = \"1.8 s\""},
    {"[[event]]", "condition trigger if on triggers conditions", "when",
     "when = { reaction_force = \"arm/elbow\", exceeds = \"4 kN\" }", false},
    {"[[event]]", "period interval", "every", "every = \"0.5 s\""},
    {"[[event]]", "start begin offset", "from", "from = \"1 s\""},
    {"[[event]]", "hold holds duration lasting", "for", "for = \"5 ms\""},
    {"[[event]]", "repeats recurring again", "repeat", "repeat = true"},
    {"[[event]]", "delay", "", "write after = { event = \"grasp\", delay = \"0.5 s\" }"},
    {"[[event]]", "remove cut detach disconnect delete snap fracture sever disable brake separate unweld drop disjoin", "break",
     "break = \"arm/elbow\""},
    {"[[event]]", "freeze fix jam block clamp", "lock", "lock = \"arm/elbow\""},
    {"[[event]]", "unfreeze unjam unblock unclamp", "unlock", "unlock = \"arm/elbow\""},
    {"[[event]]", "release enable", "",
     "`break` removes a joint, `free` gives it six degrees of freedom, `unlock` ends a `lock`"},
    {"[[event]]", "glue join fuse merge stick", "weld", "weld = { body = \"satellite/hull\", to = \"tug/gripper\" }"},
    {"[[event]]", "connect grasp dock couple hook capture pin", "attach",
     "attach = { body = \"load/hook\", to = \"crane/rope\", kind = \"ball\" }"},
    {"[[event]]", "loosen", "free", "free = \"arm/elbow\""},
    {"[[event]]", "kick hit blow applyimpulse push", "impulse", "impulse = { body = \"arm/hand\", force = [\"2 N s\", 0, 0] }"},
    {"[[event]]", "update modify setparameters parameters", "set", "set = { joint = \"arm/elbow\", damping = 0.1 }"},
    {"[[event]]", "convert replace become", "change", "change = { joint = \"arm/elbow\", kind = \"ball\" }"},
    {"[[event]]", "action actions do then joint body type kind target", "",
     "an action is a separate key: break = \"arm/elbow\", or lock, weld, impulse, set …"},
    {"[[event]]", "force applyforce torque wrench", "",
     "a force that lasts is a [[force]] table, a blow is impulse = { body = \"arm/hand\", force = [\"2 N s\", 0, 0] }"},
    {"[[event]]", "drive motor", "", "write set = { joint = \"arm/elbow\", drive = { effort = \"5 N m\" } }"},

    {"when", "above over greater greaterthan morethan gt ge larger", "exceeds", "exceeds = \"4 kN\""},
    {"when", "under less lessthan lt le smaller fallsbelow", "below", "below = \"0.3 m\""},
    {"when", "threshold value limit max min level equals crosses", "",
     "the threshold is exceeds = \"4 kN\", or below = \"0.3 m\""},
    {"when", "force load jointforce reactionforces tension", "reaction_force", "reaction_force = \"arm/elbow\""},
    {"when", "torque moment jointtorque effort", "reaction_torque", "reaction_torque = \"arm/elbow\""},
    {"when", "impulse", "reaction_impulse", "reaction_impulse = \"arm/elbow\""},
    {"when", "angle q coordinate displacement theta", "position", "position = \"arm/elbow\""},
    {"when", "velocity rate v omega angularvelocity", "speed", "speed = \"arm/elbow\""},
    {"when", "energy ke kinetic", "kinetic_energy", "kinetic_energy = \"arm\""},
    {"when", "dist proximity range", "distance", "distance = [\"tug/gripper\", \"satellite/hull\"]"},
    {"when", "z altitude y elevation", "height", "height = \"arm/hand\""},
    {"when", "time t at", "", "an instant replaces `when`: at = \"3 s\""},
    {"when", "joint body quantity type kind", "", above_or_below},
    {"when", "collision contact contacts hits collides touches", "touch", "touch = [\"crate\", \"floor\"]"},
    {"when", "clearance separation surfacedistance", "gap", "gap = [\"crate\", \"floor\"]"},
    {"when", "sliding slides slipping slips", "slip", "slip = [\"crate\", \"floor\"]"},
    {"reaction", "axis direction dof", "component", "component = \"fx\""},
    {"reaction", "name", "joint", "joint = \"arm/elbow\""},

    {"after", "name", "event", "event = \"grasp\""},
    {"after", "time dt wait seconds t by", "delay", "delay = \"0.5 s\""},

    {"weld|attach", "child body1 a source object link", "body", "body = \"satellite/hull\""},
    {"weld|attach", "parent body2 b target with onto", "to", "to = \"tug/gripper\""},
    {"weld", "kind type axis at", "", "a joint of another kind is made by attach = { body = …, to = …, kind = \"ball\" }"},
    {"change", "to newkind into", "kind", "kind = \"ball\""},
    {"break|free|change|lock|unlock|set", "name", "joint", "joint = \"arm/elbow\""},
    {"lock|unlock", "axes dofs dof freedom axis coordinates", "freedoms", "freedoms = [0, 2], by their numbers in v", false},
    {"impulse", "linear j impulse linearimpulse", "force", "force = [\"2 N s\", 0, 0]"},
    {"impulse", "angular angularimpulse moment", "torque", "torque = [0, 0, \"0.1 N m s\"]"},
    {"impulse", "joint", "body", "body = \"arm/hand\"", false},
    {"impulse|[[force]]", "at position pos location application applicationpoint", "point", "point = [0.1, 0, 0]"},
    {"set", "body mass inertia com", "", "masses cannot change: `set` changes parameters of joints, as in damping = 0.1"},
    {"set", "angle q position speed v state velocity", "",
     "a moving joint cannot be repositioned: use an impulse, or drive = { pd = … }"},
    {"set", "kp kd target pd effort torque force motion", "",
     "write drive = { pd = { kp = 100, kd = 10, target = \"30 deg\" } }, or drive = { effort = \"5 N m\" }"},
    {"set", "kind axis", "", "another kind or axis is given by change = { joint = …, kind = \"ball\" }"},

    {"[[force]]", "link on target", "body", "body = \"arm/hand\""},
    {"[[force]]", "vector f value xyz linear", "force", "force = [\"10 N\", 0, 0]"},
    {"[[force]]", "moment angular", "torque", "torque = [0, 0, \"2 N m\"]"},
    {"[[force]]", "frame coordinates reference expressedin", "axes", "axes = \"body\"", false},
    {"[[force]]", "resistance airresistance", "drag", "drag = { quadratic = \"0.6 kg/m^3\", area = \"0.5 m^2\" }", false},
    {"[[force]]", "wrench", "", "write force = [\"10 N\", 0, 0] and torque = [0, 0, \"2 N m\"]"},
    {"[[force]]", "joint", "", "a joint is driven by its own key: drive = { effort = \"5 N m\" }"},
    {"[[force]]", "start end from until duration time", "",
     "write a force that begins and ends as a function of time: force = [{ table = [[0, 0], [\"1 s\", 5]] }, 0, 0]"},
    {"drag", "cd coefficient dragcoefficient rho density", "",
     "with an area, quadratic is half of density times drag coefficient: drag = { quadratic = \"0.6 kg/m^3\", area = \"0.5 m^2\" "
     "}"},
    {"drag", "k c damping viscous", "linear", "linear = \"0.1 N s/m\""},

    {"[[spring]]", "start begin body1 bodya first a child anchor origin site1", "from",
     "from = { body = \"crane/jib\", point = [2, 0, 0] }"},
    {"[[spring]]", "end body2 bodyb second b parent site2", "to", "to = { body = \"ground\", point = [0, 0, 3] }"},
    {"[[spring]]", "k spring stiff springstiffness springconstant springrate", "stiffness", "stiffness = \"2 kN/m\""},
    {"[[spring]]", "c d damper viscosity dampingcoefficient", "damping", "damping = \"10 N s/m\""},
    {"[[spring]]", "length l l0 springlength freelength restlength unstretchedlength naturallength reference equilibrium", "rest",
     "rest = \"1.5 m\""},
    {"[[spring]]", "unilateral rope cable pullonly onlytension ropelike", "tension_only", "tension_only = true"},
    {"[[spring]]", "maxforce breakforce breakingforce breakload maxload breakingload limit", "strength", "strength = \"4 kN\""},
    {"[[spring]]", "joint", "", "a spring of a joint is given by its own keys: stiffness and rest in [mechanism.body.joint]"},

    {"[[cable]]", "start begin body1 bodya first a anchor site1", "from", "from = { body = \"tug/hull\", point = [1, 0, 0] }"},
    {"[[cable]]", "end body2 bodyb second b site2", "to", "to = { body = \"ground\", point = [0, 0, 3] }"},
    {"[[cable]]", "rest l l0 maxlength restlength range", "length", "length = \"12 m\""},
    {"[[cable]]", "stiffness k damping d tensiononly", "",
     "a cable does not stretch: a rope that does is a [[spring]] with tension_only = true"},
    {"[[cable]]", "e bounce cor rebound", "restitution", "restitution = 0.2"},
    {"[[cable]]", "maxforce breakforce breakingforce breakload maxload breakingload limit maxtension", "strength",
     "strength = \"4 kN\""},

    {"[[coupling]]", "follower slave child joint2", "joint", "joint = \"hand/finger2\""},
    {"[[coupling]]", "leader master parent joint1 mimic follow driver", "follows", "follows = \"hand/finger1\""},
    {"[[coupling]]", "ratio gear gearratio factor scale", "multiplier", "multiplier = -0.5"},
};

}  // namespace

std::span<const Mistake> of_events() { return mistakes_in_events; }

}  // namespace momentree::io::mistakes
