/* Five-axis kinematics of trunnion, for the servo cycle of a control. MIT OR Apache-2.0.
 * Made by cbindgen from crates/trunnion-rt/src/interface.rs: change that file, not this one. */

#ifndef TRUNNION_RT_H
#define TRUNNION_RT_H

#include <stddef.h>
#include <stdint.h>

// Number of axes: X, Y, Z and two rotaries.
#define TRUNNION_AXES 5

// Numbers of a pose: tip, and unit vector from tip to spindle.
#define TRUNNION_POSE 6

// Number of letters of a pose.
#define TRUNNION_LETTERS 9

// A block begins on the move, on the move at an exact place (outputs), or at rest.
#define TRUNNION_BEGINS_FLOW 0

// See `TRUNNION_BEGINS_FLOW`.
#define TRUNNION_BEGINS_MARKED 1

// See `TRUNNION_BEGINS_FLOW`.
#define TRUNNION_BEGINS_REST 2

// A block ends at rest, exactly on the path, or rounded within the tolerance.
#define TRUNNION_ENDS_STOP 0

// See `TRUNNION_ENDS_STOP`.
#define TRUNNION_ENDS_EXACT 1

// See `TRUNNION_ENDS_STOP`.
#define TRUNNION_ENDS_BLEND 2

// A block moves at its speed at most, as a rapid move, or in the time that its speed makes of its length.
#define TRUNNION_MOVES_FEED 0

// See `TRUNNION_MOVES_FEED`.
#define TRUNNION_MOVES_RAPID 1

// See `TRUNNION_MOVES_FEED`.
#define TRUNNION_MOVES_TIMED 2

// Number of a reason; 0 is no refusal. Numbers keep their meaning in later versions.
enum TrunnionRefusal
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // Nothing is refused.
  TRUNNION_REFUSAL_NONE = 0,
  // An axis would leave its travel.
  TRUNNION_REFUSAL_OUT_OF_TRAVEL = 1,
  // The rotaries cannot turn the tool into this direction.
  TRUNNION_REFUSAL_UNREACHABLE = 2,
  // The linear axes lie in one plane with the rotaries where they are.
  TRUNNION_REFUSAL_FLAT_SLIDES = 3,
  // A number is NaN or infinite.
  TRUNNION_REFUSAL_NOT_FINITE = 4,
  // The tool length changed with the tool tilted: the linear axes would have to jump.
  TRUNNION_REFUSAL_LENGTH_CHANGED = 5,
  // The control asked for a kind of kinematics that does not exist.
  TRUNNION_REFUSAL_UNKNOWN_MODE = 6,
  // A fault inside the library, or a null pointer from its caller.
  TRUNNION_REFUSAL_INTERNAL = 7,
  // A block moves a letter for which the machine has no axis.
  TRUNNION_REFUSAL_NO_AXIS = 8,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum TrunnionRefusal TrunnionRefusal;
#else
typedef int32_t TrunnionRefusal;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Kind of kinematics, with the number that a control switches by.
enum TrunnionMode
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // Words are joints.
  TRUNNION_MODE_AXES = 0,
  // X, Y and Z are the tool tip in the table frame.
  TRUNNION_MODE_TOOL_CENTER_POINT = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum TrunnionMode TrunnionMode;
#else
typedef int32_t TrunnionMode;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Machine with its switch between plain axes (0) and tool-centre-point control (1).
typedef struct Trunnion Trunnion;

// Planner with its thread; this end belongs to the servo thread.
typedef struct TrunnionPlanner TrunnionPlanner;

// Result of a call: a `RefusalCode`, 0 where nothing is refused.
typedef struct TrunnionStatus {
  // Number of the reason; `trunnion_refusal_text` has its text.
  int32_t code;
  // Index of the axis that is outside its travel; -1 for none.
  int32_t axis;
  // Distance outside, in mm or rad.
  double excess;
} TrunnionStatus;

// Axis of a machine. Positions and rates are in mm or rad, and s.
typedef struct TrunnionAxis {
  // Upper-case letter of its words.
  char letter;
  // 1: rotary; 0: linear.
  int32_t rotary;
  // Lower end of travel; minus infinity on an axis that turns without end.
  double low;
  // Upper end of travel.
  double high;
} TrunnionAxis;

// A block of a program.
typedef struct TrunnionBlock {
  // Number that `trunnion_planner_cycle` reports back.
  uint32_t number;
  // Position at the start.
  double start[TRUNNION_LETTERS];
  // Position at the end.
  double end[TRUNNION_LETTERS];
  // 1: an arc in X Y Z, the rest in proportion; 0: a line.
  int32_t arc;
  // Full turns of an arc besides itself; from -1 downwards it turns clockwise about its normal.
  int32_t turns;
  // Centre of an arc.
  double center[3];
  // Normal of an arc.
  double normal[3];
  // One of `TRUNNION_MOVES_..`.
  int32_t kind;
  // One of `TRUNNION_BEGINS_..`.
  int32_t begins;
  // One of `TRUNNION_ENDS_..`.
  int32_t ending;
  // Number of the kinematics: 0 plain axes, 1 tool-centre-point control.
  int32_t mode;
  // Programmed speed: of X Y Z; of U V W if those rest; of A B C if nothing else moves. In mm/s or rad/s.
  double speed;
  // Largest deviation of the tip at the corner at the end, in mm.
  double tolerance;
  // Length of the tool, in mm.
  double tool_length;
} TrunnionBlock;

// Position and state of a servo cycle.
typedef struct TrunnionSample {
  // Position of the letters.
  double position[TRUNNION_LETTERS];
  // Velocity of the letters.
  double velocity[TRUNNION_LETTERS];
  // Block that is run, or the last one.
  uint32_t block;
  // 1: nothing moves.
  int32_t rests;
  // 1: at rest behind the last block.
  int32_t done;
} TrunnionSample;

// Reason why a program cannot go on.
typedef struct TrunnionFault {
  // Block that is refused; the tool stops before it.
  uint32_t block;
  // Number of the reason, a `TrunnionRefusal`.
  int32_t code;
  // Axis outside its travel; for `TRUNNION_REFUSAL_NO_AXIS` the letter; -1 for none.
  int32_t axis;
  // Distance outside, in mm or rad.
  double excess;
} TrunnionFault;

// State of the plan, for people.
typedef struct TrunnionPlannerState {
  // Time until rest of what the servo thread has, in s.
  double ahead;
  // Longest turn of the planning thread, in s.
  double longest_turn;
  // Time that the planning thread has worked, in s.
  double worked;
  // Number of plans that came too late.
  uint32_t late;
  // Limit that binds: 0 none, 1 feed, 2 rapid; 10, 20 or 30 and the axis for its velocity, acceleration or jerk.
  uint32_t limit;
} TrunnionPlannerState;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// Opens a machine file, or a built-in machine by its name. Returns null where that fails, with the reason as text in
// `message`, which holds `size` bytes. `trunnion_close` frees the machine.
//
// # Safety
//
// `name` is a string that ends with a zero byte; `message` is null or points to `size` writable bytes.
struct Trunnion *trunnion_open(const char *name, char *message, size_t size);

// Reads the text of a machine file, as `trunnion_open` reads a file.
//
// # Safety
//
// As `trunnion_open`.
struct Trunnion *trunnion_read(const char *text, char *message, size_t size);

// Frees a machine; null is ignored.
//
// # Safety
//
// `machine` comes from `trunnion_open` or `trunnion_read`, and is not used after this call.
void trunnion_close(struct Trunnion *machine);

// Describes an axis; `index` counts from 0 in the order of joints.
//
// # Safety
//
// `machine` is open; `axis` points to a writable `TrunnionAxis`.
struct TrunnionStatus trunnion_axis(const struct Trunnion *machine, size_t index, struct TrunnionAxis *axis);

// Compares the joints of an INI file of `LinuxCNC` with the axes of a machine. Returns the number of differences because of
// which the machine cannot run by both files, -1 for a file that cannot be read; `message`, which holds `size` bytes, has a
// line for each, with the remedy.
//
// # Safety
//
// `machine` is open; `path` is a string that ends with a zero byte; `message` is null or points to `size` writable bytes.
int32_t trunnion_ini(const struct Trunnion *machine,
                     const char *path,
                     char *message,
                     size_t size);

// Switches to plain axes (0) or tool-centre-point control (1), with the length of the tool in the spindle.
//
// # Safety
//
// `machine` is open.
struct TrunnionStatus trunnion_switch(struct Trunnion *machine, int32_t mode, double tool_length);

// Computes the words at which the machine stands, by its joints. Takes a changed tool length over where no axis has
// to jump for it.
//
// # Safety
//
// `machine` is open; `joints` holds `TRUNNION_AXES` numbers, `words` has room for as many.
struct TrunnionStatus trunnion_forward(struct Trunnion *machine,
                                       double tool_length,
                                       const double *joints,
                                       double *words);

// Computes the joints for words. Outside travel the joints are returned with code 1 and the axis; with every other
// code they are left as they were.
//
// # Safety
//
// As `trunnion_forward`.
struct TrunnionStatus trunnion_inverse(struct Trunnion *machine, const double *words, double *joints);

// Computes the tool pose in the table frame, by joints.
//
// # Safety
//
// `machine` is open; `joints` holds `TRUNNION_AXES` numbers, `pose` has room for `TRUNNION_POSE`.
struct TrunnionStatus trunnion_pose(const struct Trunnion *machine,
                                    double tool_length,
                                    const double *joints,
                                    double *pose);

// Computes the joints for a tool pose, inside travel, on the branch and turn nearest to the joints `near`. The
// direction of the pose may have any length but zero.
//
// # Safety
//
// `machine` is open; `pose` holds `TRUNNION_POSE` numbers, `near` holds `TRUNNION_AXES`, `joints` has room for as many
// and may be `near`.
struct TrunnionStatus trunnion_nearest(const struct Trunnion *machine,
                                       double tool_length,
                                       const double *pose,
                                       const double *near,
                                       double *joints);

// Returns the text of a refusal's number; it lives as long as the program.
const char *trunnion_refusal_text(int32_t code);

// Starts a planner for `blocks` blocks and a servo period in s. Returns null where that fails, with the reason as text
// in `message`, which holds `size` bytes. `trunnion_planner_stop` ends it.
//
// # Safety
//
// `machine` is open; `message` is null or points to `size` writable bytes.
struct TrunnionPlanner *trunnion_planner_start(const struct Trunnion *machine,
                                               size_t blocks,
                                               double period,
                                               char *message,
                                               size_t size);

// Ends a planner and its thread; null is ignored.
//
// # Safety
//
// `planner` comes from `trunnion_planner_start`, and is not used after this call.
void trunnion_planner_stop(struct TrunnionPlanner *planner);

// Hands a block over. Returns 1, or 0 where the queue is full, an abort is under way, or the block has a number that no
// block can have.
//
// # Safety
//
// `planner` is running and used by this thread alone; `block` points to a block.
int32_t trunnion_planner_push(struct TrunnionPlanner *planner, const struct TrunnionBlock *block);

// Forgets all blocks, and stands at a position at once: for a machine at rest.
//
// # Safety
//
// As `trunnion_planner_push`; `position` holds `TRUNNION_LETTERS` numbers.
void trunnion_planner_reset(struct TrunnionPlanner *planner, const double *position);

// Sets the position of a machine that rests behind its last block.
//
// # Safety
//
// As `trunnion_planner_reset`.
void trunnion_planner_place(struct TrunnionPlanner *planner, const double *position);

// Begins to stop, and to forget all blocks then.
//
// # Safety
//
// `planner` is running and used by this thread alone.
void trunnion_planner_abort(struct TrunnionPlanner *planner);

// Returns 1 until an abort has come to rest, and 0 otherwise.
//
// # Safety
//
// As `trunnion_planner_abort`.
int32_t trunnion_planner_is_aborting(const struct TrunnionPlanner *planner);

// Returns 1 at rest behind the last block, and 0 otherwise.
//
// # Safety
//
// As `trunnion_planner_abort`.
int32_t trunnion_planner_is_done(const struct TrunnionPlanner *planner);

// Plays one servo cycle with overrides of the feed and of rapid moves; 0 holds.
//
// # Safety
//
// As `trunnion_planner_abort`; `sample` is writable.
void trunnion_planner_cycle(struct TrunnionPlanner *planner, double feed, double rapid, struct TrunnionSample *sample);

// Takes the next fault of the plan. Returns 1 if there was one, and 0 otherwise.
//
// # Safety
//
// As `trunnion_planner_abort`; `fault` is writable.
int32_t trunnion_planner_fault(struct TrunnionPlanner *planner, struct TrunnionFault *fault);

// Writes the state of the plan to `state`.
//
// # Safety
//
// As `trunnion_planner_abort`; `state` is writable.
void trunnion_planner_state(const struct TrunnionPlanner *planner, struct TrunnionPlannerState *state);

// Sets the servo period in s, and the largest deviation of the rotaries at corners in rad; one that is not positive is
// left as it is.
//
// # Safety
//
// As `trunnion_planner_abort`.
void trunnion_planner_set(struct TrunnionPlanner *planner, double period, double axis_tolerance);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* TRUNNION_RT_H */
