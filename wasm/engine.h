/* The engine as a module for browsers: worlds made from scenarios' texts, that run, change and go back.
 *
 * Numbers are doubles in SI units; places point into the module's memory. Bodies and joints have numbers, from 0 in the order of
 * the scenario; a body's number never changes, nor that of a joint as long as it is there (mt_model and mt_topology name them).
 * A joint's number is also that of the body that carried it at the start.
 *
 * What is wrong with a scenario or with an action is never thrown: the function says so, and mt_text why. What could not be
 * foreseen goes to the imported function momentree.fail(text, length), which must not come back: it throws, and the instance is
 * not to be used again. */
#ifndef MOMENTREE_WASM_ENGINE_H
#define MOMENTREE_WASM_ENGINE_H
#include <stddef.h>
#ifdef __cplusplus
extern "C" {
#endif

typedef struct MtWorld MtWorld;

/* What became of a call. */
enum MtStatus {
  mt_ok = 0,
  mt_diverged = 1,    /* the last good state stays; mt_text says which joint, and what to do */
  mt_interrupted = 2, /* the time for this call was over: call again */
  mt_refused = 3      /* impossible: nothing happened; mt_text says which action and why */
};

/* Memory for texts that are handed in. */
void* mt_allocate(size_t bytes);
void mt_release(void* memory);

/* A world that is empty until something is loaded. */
MtWorld* mt_create(void);
void mt_destroy(MtWorld* world);

/* Reads a scenario (TOML, UTF-8) and makes its world. 1: done; 0: it has errors, and the world is as it was. mt_text is JSON:
 * {"diagnostics": [{"severity": "error", "line": 3, "column": 1, "what": "…", "hint": "…"}, …]} and, where it was done,
 * "scenario": {"title", "until", "every", "step", "method", "gravity": [x, y, z], "events": […]}. Files are not opened: models and
 * state documents are errors. */
int mt_load(MtWorld* world, const char* text, size_t length);

/* The text of the last call that had one, and its bytes. */
const char* mt_text(const MtWorld* world);
size_t mt_text_length(const MtWorld* world);

/* model.json of what was loaded, as a text. */
void mt_model(MtWorld* world);
/* The present topology as a text: {"mechanisms": [{"name", "root", "grounded", "bodies": […]}], "joints": [{"number", "name",
 * "kind", "parent", "child", "locked": bits, "at", "child_at", "axis", "damping", "force", "torque"}]}: numbers of bodies,
 * -1 the ground; "force" and "torque" what the joint bears, null: any. */
void mt_topology(MtWorld* world);
/* Another number whenever mt_topology may say something else. */
int mt_revision(const MtWorld* world);

/* Steps to `time` (s), onto events that are due on the way, for at most `budget` seconds of the clock. */
int mt_run(MtWorld* world, double time, double budget);
double mt_time(const MtWorld* world);

int mt_bodies(const MtWorld* world);
/* Per body 13 numbers: x, y, z and quaternion w, x, y, z of its frame in the world, velocity of the frame's origin and angular
 * velocity in world axes. NaN for a body that was removed. */
const double* mt_motions(MtWorld* world);
enum { mt_motion_size = 13, mt_joint_size = 28, mt_totals_size = 16 };
/* Per joint 28 numbers: nq, nv, q (7), v (6), p (6), the reaction on the declared child at its origin in its axes (force and
 * torque, 6), the load: the largest ratio of a reaction to what it breaks at (the joint's strength, or an event's threshold), NaN
 * where nothing says one. nq is -1 where the joint is gone; reactions are zeros unless asked for. */
const double* mt_joints(MtWorld* world, int with_reactions);
/* 16 numbers: time; kinetic, potential; linear momentum (3), angular momentum about the world's origin (3); the energy balance:
 * initial, final, dissipated, work, lost in impacts, released, error. */
const double* mt_totals(MtWorld* world);
/* Events that have happened, and those from number `first` on as a JSON array, each as a line of events.jsonl. */
int mt_event_count(const MtWorld* world);
void mt_events(MtWorld* world, int first);

/* Actions at this instant, each an event with its certificate. Joints and bodies by number; `to` of -1 is the ground. */
int mt_break(MtWorld* world, int joint);
int mt_free(MtWorld* world, int joint);
int mt_lock(MtWorld* world, int joint);
int mt_unlock(MtWorld* world, int joint);
int mt_weld(MtWorld* world, int body, int to);
/* A joint of a kind ("revolute") between two bodies where they are; axis in `to`'s frame. */
int mt_attach(MtWorld* world, int body, int to, const char* kind, size_t length, double x, double y, double z);
/* Another kind for a joint, on the axes that it has. */
int mt_change(MtWorld* world, int joint, const char* kind, size_t length);
/* World axes, at a point of the body's frame (N s). */
int mt_impulse(MtWorld* world, int body, double fx, double fy, double fz, double x, double y, double z);
/* NaN: stays. One number for all freedoms; damping (N m s or N s/m), stiffness (N m or N/m), strength (N, N m). */
int mt_set(MtWorld* world, int joint, double damping, double stiffness, double force, double torque);
/* Every joint's damping becomes its damping at the start times `factor`, plus `offset` for joints that can turn. */
int mt_set_damping(MtWorld* world, double factor, double offset);
int mt_set_gravity(MtWorld* world, double x, double y, double z);

/* A spring and a damper between a point of a body's frame and a point that follows the pointer; their strength is for the body's
 * mechanism, times `strength`. One at a time; what it does counts as work. */
int mt_grab(MtWorld* world, int body, double x, double y, double z, double strength);
void mt_pull(MtWorld* world, double x, double y, double z);
void mt_let_go(MtWorld* world);

/* All that the run is at this instant, kept until it is dropped or something else is loaded; restoring is exact to the last bit,
 * in this world and in its branches. */
int mt_snapshot(MtWorld* world);
int mt_restore(MtWorld* world, int snapshot);
void mt_drop(MtWorld* world, int snapshot);
/* Back to just before an event; what was scheduled for that instant does not happen again, unless `again`. mt_refused where the
 * history does not reach so far back. */
int mt_undo(MtWorld* world, int event, int again);
/* A run of its own from here, without what was grabbed. */
MtWorld* mt_branch(const MtWorld* world);

#ifdef __cplusplus
}
#endif
#endif
