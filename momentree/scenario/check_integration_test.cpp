// Unsuitable steps, tolerances, lengths and events are reported before anything runs.
#include <doctest/doctest.h>

#include <tests/bad_input.hpp>

namespace momentree::io {
namespace {

using namespace bad_input;

std::string of(const std::string& more, const std::vector<std::string>& overrides = {}) {
  return said(read_scenario_text(pinned + more, "s.toml", overrides));
}
std::string integrated(const std::string& lines) { return of("[integrate]\n" + lines + "\n"); }

// A horizontal pendulum of 1 m.
const std::string pendulum = head +
                             "[[mechanism.body]]\nname = \"a\"\nmass = 1\ncom = [1, 0, 0]\n[mechanism.body.joint]\n"
                             "kind = \"revolute\"\naxis = [0, 1, 0]\n";
std::string swung(const std::string& lines) { return said(read_scenario_text(pendulum + lines, "s.toml")); }

}  // namespace

TEST_CASE("usual values are accepted") {
  for (const char* lines :
       {"", "step = 1e-3\nuntil = 1", "step = \"0.1 ms\"\nuntil = \"1 h\"", "method = \"dopri5\"\nrtol = 1e-3\natol = 1e-6",
        "method = \"dop853\"\nrtol = 1e-13\natol = 1e-15", "method = \"dopri5\"\nstep = 5\nmax_step = 1", "until = 0\nstep = 1"})
    CHECK(integrated(lines) == "");
  CHECK(swung("[integrate]\nstep = \"20 ms\"\n") == "");
  CHECK(swung("[output]\nevery = \"20 ms\"\n") == "");
  CHECK(swung("[integrate]\nuntil = 100\n[output]\nevery = \"1 ms\"\n") == "");
}

TEST_CASE("inconsistent steps and lengths are reported") {
  CHECK(integrated("step = 20\nuntil = 10") ==
        "s.toml:11:8: warning: step = 20 s is longer than the whole run of 10 s; a step resolves the fastest motion: \"1 ms\" is "
        "usual");
  CHECK(
      integrated("step = 1e-9\nuntil = 100") ==
      "s.toml:11:8: warning: the run takes 1e+11 steps or more: 100 s in steps of 1e-09 s; use a longer step, or a shorter run");
  CHECK(
      integrated("method = \"dopri5\"\nmax_step = 1e-12") ==
      "s.toml:12:12: warning: the run takes 1e+13 steps or more: 10 s in steps of 1e-12 s; use a longer step, or a shorter run");
  CHECK(integrated("step = 1e-18") ==
        "s.toml:11:8: error: step = 1e-18 s is below the resolution of the clock: at the end of the run, 10 s, instants are "
        "1.78e-15 s "
        "apart; use a longer step, or a shorter run");
  CHECK(of("[integrate]\nuntil = 9e8\nstep = 1\n") ==
        "s.toml:11:9: warning: the tables would hold 9e+08 rows of 1 bodies: about 211 GB; use a longer interval between rows: "
        "[output] every = "
        "\"9e+05 s\"");
  CHECK(of("[output]\nevery = \"0.1 ms\"\n") ==
        "s.toml:11:9: warning: every = 0.0001 s is shorter than the step of 0.001 s: steps end at rows, so they will be as "
        "short; give "
        "step "
        "= 0.0001, or a longer interval between rows");
  CHECK(integrated("event_tolerance = 1") ==
        "s.toml:11:19: warning: event_tolerance = 1 s is as long as a step: the instants of events are not located; 1e-10 s is "
        "the default");
}

TEST_CASE("tolerances that allow everything, or nothing") {
  CHECK(integrated("method = \"dopri5\"\natol = 1") ==
        "s.toml:12:8: warning: atol = 1 allows an error per step of 1 rad or m, rad/s or m/s; 1e-6 to 1e-12 is usual");
  CHECK(integrated("method = \"dopri5\"\nrtol = 0.5") ==
        "s.toml:12:8: warning: rtol = 0.5 allows an error per step of 50 % of the motion; 1e-6 to 1e-10 is usual");
  CHECK(integrated("method = \"dopri5\"\natol = 1e-30") ==
        "s.toml:12:8: warning: atol = 1e-30 is below the rounding error of a velocity near zero: steps shrink without limit if "
        "anything is at rest; use 1e-15 or more; `rtol` controls the error of moving bodies");
}

TEST_CASE("steps that cannot resolve the motion are reported") {
  CHECK(
      swung("[integrate]\nstep = 1\n")
          .starts_with("s.toml:12:8: warning: step = 1 s is too long for this motion: the first step of joint 'm/a' is off by "));
  CHECK(swung("damping = 50\n[integrate]\nstep = \"0.1 s\"\n") ==
        "s.toml:13:8: warning: the damper of joint 'm/a' (damping = 50 N m s/rad on 1 kg m^2) is too stiff for steps of 0.1 s by "
        "rk4; "
        "use method = \"damped\", or a step below 0.0557 s");
  CHECK(swung("damping = 50\n[integrate]\nstep = \"0.1 s\"\nmethod = \"damped\"\n") == "");
  CHECK(
      swung("drive = { pd = { kp = 1e6 } }\n[integrate]\nstep = \"10 ms\"\n") ==
      "s.toml:13:8: warning: the servo of joint 'm/a' (kp = 1e+06 N m/rad on 1 kg m^2) is too stiff for steps of 0.01 s by rk4; "
      "use a step below 0.00297 s");
}

TEST_CASE("events after the end give warnings, and so do those that follow them") {
  const std::string impulse = "impulse = { body = \"m/a\", force = [1, 0, 0] }\n";
  const auto event = [&](const std::string& lines) { return "[[event]]\n" + lines + "\n" + impulse; };
  const std::string cure = "; make the run longer, as in until = \"20 s\", or the event earlier";
  CHECK(of(event("at = 20")) ==
        "s.toml:10:1: warning: event '#1' cannot happen: it is due at 20 s, but the run ends at 10 s" + cure);
  CHECK(of(event("at = 10")) == "");
  CHECK(of(event("every = 1\nfrom = 20")) ==
        "s.toml:10:1: warning: event '#1' cannot happen: it is due at 20 s, but the run ends at 10 s" + cure);
  CHECK(of(event("every = 100")) == "");
  const std::string first = event("name = \"first\"\nat = 4");
  CHECK(of(first + event("name = \"second\"\nafter = { event = \"first\", delay = 4 }") +
           event("after = { event = \"second\", delay = 12 }")) ==
        "s.toml:18:1: warning: event '#3' cannot happen: it is due at 20 s at the earliest, but the run ends at 10 s" + cure);
  CHECK(of(first + event("after = { event = \"first\", delay = 6 }")) == "");
  const std::string waits = "when = { speed = \"m/a\", exceeds = 100 }";
  CHECK(of(event(waits)) == "");
  CHECK(of(event(waits + "\nfor = 20")) ==
        "s.toml:10:1: warning: event '#1' cannot happen: it is due at 20 s at the earliest, but the run ends at 10 s" + cure);
  CHECK(of("strength = { force = 1e6 }\n" + event("after = { event = \"strength of m/a\", delay = 20 }")) ==
        "s.toml:11:1: warning: event '#1' cannot happen: it is due at 20 s at the earliest, but the run ends at 10 s" + cure);
  CHECK(of(event("at = 20"), {"integrate.until=2"}) == "");  // intended
  // The search ends even if delays form a cycle.
  CHECK(of(event("name = \"x\"\nat = 1") + event("name = \"y\"\nafter = \"x\"") +
           event("name = \"z\"\nafter = { event = \"z\", delay = 1 }"))
            .find("there is no event 'z'") != std::string::npos);
}

}  // namespace momentree::io
