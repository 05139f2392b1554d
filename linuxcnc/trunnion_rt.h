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

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* TRUNNION_RT_H */
