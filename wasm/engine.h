/* The engine as a module for browsers: worlds that are made from scenario texts, run, changed and restored.
 *
 * Quantities are doubles in SI units; pointers refer to the module's memory. Bodies and joints are numbered from 0 in the order
 * of the scenario; joints that close loops have numbers from 268435456 (2^28) on. A body's number never changes, and a joint keeps
 * its number for as long as it exists (mt_model and mt_topology give the names), but for one that takes the place of a broken joint
 * in the tree. The body that a joint carries at the start has the same number as the joint.
 *
 * Errors in a scenario or an action are never thrown: the function's result reports them, and mt_text gives the reason.
 * Unexpected errors are passed to the imported function momentree.fail(text, length), which must not return: it throws, and the
 * instance must not be used again. */
#ifndef MOMENTREE_WASM_ENGINE_H
#define MOMENTREE_WASM_ENGINE_H
#include <stddef.h>
#ifdef __cplusplus
extern "C" {
#endif

typedef struct MtWorld MtWorld;

/* Result of a call. */
enum MtStatus {
  mt_ok = 0,
  mt_diverged = 1,    /* the last good state is kept; mt_text says which joint diverged, and suggests remedies */
  mt_interrupted = 2, /* the time budget of this call was used up: call again */
  mt_refused = 3      /* impossible: nothing happened; mt_text says which action and why */
};

/* Memory for texts that are passed in. */
void* mt_allocate(size_t bytes);
void mt_release(void* memory);

/* Makes a world, which is empty until a scenario is loaded. */
MtWorld* mt_create(void);
void mt_destroy(MtWorld* world);

/* Reads a scenario (TOML, UTF-8) and makes its world. Returns 1 on success, 0 if it has errors and the world is
 * unchanged. mt_text is JSON: {"diagnostics": [{"severity": "error", "line": 3, "column": 1, "what": "…", "hint": "…"}, …]} and,
 * on success, "scenario": {"title", "until", "every", "step", "method", "gravity": [x, y, z], "events": […]}. Files are not
 * opened: references to models and state documents are errors. */
int mt_load(MtWorld* world, const char* text, size_t length);
/* The same with a floor below the mechanisms, on which all bodies land (docs/howto/play.md). The text says in "scenario" with
 * "floor" whether that changed the scenario. */
int mt_load_on_floor(MtWorld* world, const char* text, size_t length);

/* The text of the last call that produced one (UTF-8), and its length in bytes. */
const char* mt_text(const MtWorld* world);
size_t mt_text_length(const MtWorld* world);

/* Sets the text to model.json of the loaded scenario. */
void mt_model(MtWorld* world);
/* Sets the text to the kinds of joint with the units of their coordinates, velocities and momenta: {"revolute": {"q": ["rad"],
 * "v": ["rad/s"], "p": ["N m s"]}, …}. The components of a quaternion (w, x, y, z) have the unit "". */
void mt_kinds(MtWorld* world);
/* Sets the text to the present topology: {"mechanisms": [{"name", "root", "grounded", "bodies": […]}], "joints": [{"number",
 * "row", "name", "kind", "parent", "child", "locked": bits, "at", "child_at", "axis", "damping", "stiffness", "force", "torque", "loop"}]}:
 * bodies by number, -1: the ground; "row": the joint's place in mt_joints; "force" and "torque": the joint's strength, null:
 * unlimited; "loop": true for a joint that closes a loop, absent for others. "broken_springs": names, absent if the model has no springs;
 * "couplings": [{"joint", "follows", "ended"}], the exact couplings of joints by name, absent if the model has none. */
void mt_topology(MtWorld* world);
/* Changes whenever the result of mt_topology may have changed. */
int mt_revision(const MtWorld* world);

/* Steps to `time` (s), landing on events that are due before, for at most `budget` seconds of wall-clock time. */
int mt_run(MtWorld* world, double time, double budget);
double mt_time(const MtWorld* world);

int mt_bodies(const MtWorld* world);
/* Per body 13 numbers: x, y, z and quaternion w, x, y, z of its frame in the world, velocity of the frame's origin and angular
 * velocity in world axes. NaN for a removed body. */
const double* mt_motions(MtWorld* world);
/* The same for the loaded scenario at other coordinates and at rest, whatever the present state: `q` has the coordinates of all
 * joints of the tree in the order of their numbers; prescribed motions are at time 0. Loops are closed by the
 * least change of the joints whose coordinates are as in the last call's result, or as at the start, so that a joint that is moved
 * stays where it was put; if that is impossible, the result is that of the last call. The world does not change. mt_posed: the
 * resulting coordinates, as in `q`. */
const double* mt_motions_at(MtWorld* world, const double* q);
const double* mt_posed(const MtWorld* world);
enum { mt_motion_size = 13, mt_joint_size = 29, mt_totals_size = 17, mt_contact_size = 15 };
/* Per joint 29 numbers: nq, nv, q (7), v (6), p (6), the reaction on the declared child about the joint's frame there, in the
 * child's axes (force and torque, 6), the load: the largest ratio of a reaction to the value at which the joint breaks (its
 * strength, or an event's threshold), NaN if there is none; 0 if closed loops leave the reaction open (it is then the least of those possible), else 1.
 * First the joints of the tree in the order of their numbers, then those that close loops: a joint keeps its row for as long as it
 * has its number. nq is -1 where there is no joint (any more); p of a joint that closes a loop is zero; reactions are zero unless
 * requested. */
const double* mt_joints(MtWorld* world, int with_reactions);
int mt_joint_rows(const MtWorld* world);
/* The points at which bodies touch; computes the forces there and returns how many there are. mt_contact_numbers: 15 of each:
 * the numbers of both bodies (-1: the ground, only the second), point (3), normal from the second to the first body (3), force on
 * the first body (3, N), velocity of slip (3, m/s), and 1 if it slips. World axes. */
int mt_contacts(MtWorld* world);
const double* mt_contact_numbers(const MtWorld* world);
/* 17 numbers: time; kinetic, potential; linear momentum (3), angular momentum about the world's origin (3); the energy balance:
 * initial, final, dissipated, work, lost in impacts, released, error, and the energy that keeping loops closed brought in. */
const double* mt_totals(MtWorld* world);
/* Number of events that have happened; sets the text to those from number `first` on, a JSON array of lines of events.jsonl. */
int mt_event_count(const MtWorld* world);
void mt_events(MtWorld* world, int first);

/* Actions at this instant, each as an event with its certificate. Joints and bodies by number; `to` = -1 is the ground. */
int mt_break(MtWorld* world, int joint);
int mt_free(MtWorld* world, int joint);
int mt_lock(MtWorld* world, int joint);
int mt_unlock(MtWorld* world, int joint);
int mt_weld(MtWorld* world, int body, int to);
/* Joins two bodies in their present poses by a joint of a kind ("revolute"); axis in `to`'s frame. */
int mt_attach(MtWorld* world, int body, int to, const char* kind, size_t length, double x, double y, double z);
/* Changes the kind of a joint; its axes stay. */
int mt_change(MtWorld* world, int joint, const char* kind, size_t length);
/* Impulse (N s) in world axes at a point of the body's frame (m). */
int mt_impulse(MtWorld* world, int body, double fx, double fy, double fz, double x, double y, double z);
/* Sets parameters; NaN: unchanged. One value for all DoFs; damping (N m s or N s/m), stiffness (N m or N/m), strength (N, N m).
 */
int mt_set(MtWorld* world, int joint, double damping, double stiffness, double force, double torque);
/* Sets every joint's damping to its initial damping times `factor`, plus `offset` (N m s) for joints that can rotate. */
int mt_set_damping(MtWorld* world, double factor, double offset);
/* Sets the force at which every joint breaks (N) to that of the scenario or, if that is smaller, to `force`. */
int mt_limit_strength(MtWorld* world, double force);
int mt_set_gravity(MtWorld* world, double x, double y, double z);

/* A spring and a damper between a point of a body's frame (m) and a target point that follows the pointer (mt_pull, world
 * axes, m). Their constants suit the body's mechanism and are scaled by `strength`. One grip at a time; its effect counts as
 * work. */
int mt_grab(MtWorld* world, int body, double x, double y, double z, double strength);
void mt_pull(MtWorld* world, double x, double y, double z);
void mt_release_grip(MtWorld* world);

/* Takes a snapshot of the complete run, which is kept until it is dropped or another scenario is loaded. Restoring it, in this
 * world or in its branches, is exact to the last bit. */
int mt_snapshot(MtWorld* world);
int mt_restore(MtWorld* world, int snapshot);
void mt_drop(MtWorld* world, int snapshot);
/* Returns to just before an event; the actions scheduled for that instant do not happen again unless `again` is set. Returns
 * mt_refused if the history does not reach back that far. */
int mt_undo(MtWorld* world, int event, int again);
/* An independent run from here, without the grip. */
MtWorld* mt_branch(const MtWorld* world);

#ifdef __cplusplus
}
#endif
#endif
