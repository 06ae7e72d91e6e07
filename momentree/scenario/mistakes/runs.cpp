// The whole scenario, [world], [integrate] and [output].
#include <momentree/scenario/mistakes/keys.hpp>

namespace momentree::io::mistakes {

namespace {

constexpr const char* in_integrate = "it belongs in [integrate]: method = \"rk4\", step = \"1 ms\", until = \"3 s\"";

constexpr Mistake mistakes_in_runs[] = {
    {"[integrate]", "dt h timestep stepsize steplength fixedstep maxtimestep initialstep deltat", "step", "step = \"1 ms\""},
    {"[integrate]",
     "end duration tend endtime stoptime stop tstop time t tmax finaltime tfinal simulationtime simtime length runtime horizon "
     "finish tf maxtime",
     "until", "until = \"3 s\""},
    {"[integrate]", "integrator solver scheme algorithm type kind", "method", "method = \"dopri5\""},
    {"[integrate]", "tolerance tol reltol relativetolerance accuracy epsrel precision relerr", "rtol", "rtol = 1e-8"},
    {"[integrate]", "abstol absolutetolerance epsabs abserr", "atol", "atol = 1e-10"},
    {"[integrate]", "maxdt dtmax maxstepsize maximumstepsize hmax maxh maxdeltat", "max_step", "max_step = \"10 ms\""},
    {"[integrate]", "eventtol zerocrossingtolerance eventaccuracy", "event_tolerance", "event_tolerance = \"1e-9 s\""},
    {"[integrate]", "gravity g", "", "it belongs in [world]: gravity = [0, 0, -9.81]"},
    {"[integrate]", "every output interval outputstep savestep outputinterval", "", "it belongs in [output]: every = \"10 ms\""},
    {"[integrate]", "substeps iterations maxiterations niter", "", "use a smaller step instead: step = \"0.25 ms\""},
    {"[integrate]", "start starttime t0 tstart", "",
     "a run starts at 0 s, or at the end of the document in `state = \"final.json\"`"},
    {"[integrate]", "steps nsteps numsteps numberofsteps", "", "the length of a run is a time: until = \"3 s\""},
    {"[integrate]", "realtime threads seed", "", "there is no such setting: runs are as fast as possible and deterministic"},

    {"[world]", "g grav gravitation gravityvector gravitationalacceleration", "gravity", "gravity = [0, 0, -9.81]"},
    {"[world]", "dt timestep step until duration method integrator", "", in_integrate},
    {"[world]", "plane ground groundplane contact contacts collision collisions friction restitution", "",
     "contact is not supported yet"},

    {"a scenario", "name description comment heading", "title", "title = \"Breaking chain\""},
    {"a scenario", "version formatversion fileformat", "format", "format = 1"},
    {"a scenario", "environment physics", "world", "[world]"},
    {"a scenario", "mechanisms system systems assembly multibody", "mechanism", "[[mechanism]]"},
    {"a scenario", "model models robot robots urdf mjcf sdf include import file", "",
     "a model file is a mechanism: [[mechanism]] with name = \"robot\" and model = \"robot.urdf\""},
    {"a scenario", "body bodies link links part parts", "",
     "bodies belong to a mechanism: [[mechanism]] with a name, then its [[mechanism.body]] tables"},
    {"a scenario", "joint joints", "",
     "a joint is given with the body that it carries: [mechanism.body.joint] below its [[mechanism.body]]"},
    {"a scenario", "events trigger triggers action actions", "event", "[[event]]"},
    {"a scenario", "forces load loads externalforce externalforces", "force", "[[force]]"},
    {"a scenario", "springs rope ropes tendon tendons guy guys", "spring", "[[spring]]"},
    {"a scenario", "cables tether tethers wire wires string strings", "cable", "[[cable]]"},
    {"a scenario", "couplings gear gears transmission transmissions mimic", "coupling", "[[coupling]]"},
    {"a scenario",
     "loops constraint constraints equality equalities connect closure closures closedloop loopjoint loopjoints kinematicloop "
     "bilateral bilaterals",
     "loop", "[[loop]] with body = \"arm/hand\", to = \"arm/base\" and kind = \"ball\""},
    {"a scenario", "actuator actuators motor motors controller servo drive", "",
     "a joint is driven by its own key: drive = { effort = \"5 N m\" } in [mechanism.body.joint]"},
    {"a scenario", "integrator integration simulation simulate simulator solver settings options config run time", "integrate",
     "[integrate]"},
    {"a scenario", "outputs record recording results result log logging", "output", "[output]"},
    {"a scenario", "initialstate initial start initialconditions keyframe", "state", "state = \"final.json\""},
    {"a scenario", "gravity g", "", "it belongs in [world]: gravity = [0, 0, -9.81]"},
    {"a scenario", "dt timestep step method until end duration rtol atol tolerance", "", in_integrate},
    {"a scenario", "every interval", "", "it belongs in [output]: every = \"10 ms\""},

    {"[output]", "step dt interval period timestep sampletime samplingtime outputstep saveat saveevery", "every",
     "every = \"10 ms\""},
    {"[output]", "rate frequency fps hz samplerate samplingrate", "",
     "give the time between rows: every = \"10 ms\" is 100 rows a second"},
    {"[output]", "file folder dir directory path name filename out prefix", "",
     "`momentree run --out DIR` sets the folder of the results"},
    {"[output]", "format type", "", "tables are CSV, the rest is JSON"},
    {"[output]", "reactions forces columns fields report", "",
     "use an option of `momentree run`: --reactions adds the reactions of joints, --report a page"},
};

}  // namespace

std::span<const Mistake> of_runs() { return mistakes_in_runs; }

}  // namespace momentree::io::mistakes
