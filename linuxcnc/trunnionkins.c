/* SPDX-License-Identifier: GPL-2.0-or-later
 *
 * trunnionkins: kinematics of LinuxCNC for every machine file of trunnion.
 *
 *     loadrt trunnionkins machine=PATH [coordinates=XYZBC]
 *
 * This program is free software; you can redistribute it and/or modify it under the terms of the GNU General Public
 * License as published by the Free Software Foundation; either version 2 of the License, or (at your option) any later
 * version. It comes without any warranty. See README.md beside this file.
 *
 * Type 0, at the start: plain axes. Type 1: X, Y and Z are the tool tip. `motion.switchkins-type` selects.
 * The mathematics is in the library behind trunnion_rt.h; this file translates between degrees and radians, letters
 * and joints, and keeps the HAL pins.
 */
#include "rtapi.h"
#include "rtapi_app.h"
#include "rtapi_ctype.h"
#include "rtapi_math.h"
#include "rtapi_string.h"
#include "hal.h"
#include "emcmotcfg.h"
#include "kinematics.h"
#include "trunnion_rt.h"

MODULE_AUTHOR("trunnion");
MODULE_DESCRIPTION("Five-axis kinematics from a machine file");
MODULE_LICENSE("GPL");

static char *machine;
RTAPI_MP_STRING(machine, "machine file, or name of a built-in machine");
static char *coordinates;
RTAPI_MP_STRING(coordinates, "letters of joints 0, 1, 2 ..; a letter may come twice");

#define DEGREES (180.0 / M_PI)
#define KINDS 2
/* Distance outside travel that rounding explains, mm or degrees: programs are written with four decimals. */
#define ROUNDING 0.001

struct pins {
    hal_float_t *tool_offset;     /* length of the tool in the spindle, mm */
    hal_s32_t *refusal;           /* reason of the last refusal */
    hal_s32_t *refusal_joint;     /* joint that was outside its travel; -1: none */
    hal_float_t *refusal_excess;  /* distance outside, mm or degrees */
    hal_u32_t *refusals;          /* number of refusals */
    hal_s32_t *inverse_ns;        /* time of the last inverse */
    hal_s32_t *inverse_ns_max;    /* longest time; may be set back */
    hal_bit_t *kinstype_is[KINDS];
};

static struct pins *pins;
static int component = -1;
static Trunnion *kinematics;
static TrunnionAxis axes[TRUNNION_AXES];
/* Axis of each joint, -1 for none, and the first joint of each axis. */
static int axis_of_joint[EMCMOT_MAX_JOINTS];
static int joint_of_axis[TRUNNION_AXES];
/* Reason of the refusal at hand, so that it is written to the log once. */
static int standing_refusal;

static double *letter(EmcPose *pose, char name)
{
    switch (name) {
    case 'X': return &pose->tran.x;
    case 'Y': return &pose->tran.y;
    case 'Z': return &pose->tran.z;
    case 'A': return &pose->a;
    case 'B': return &pose->b;
    default: return &pose->c;
    }
}

/* Units of an axis in one radian or millimetre. */
static double unit(int axis)
{
    return axes[axis].rotary ? DEGREES : 1.0;
}

/* A joint is outside its travel by more than rounding. */
static int outside(TrunnionStatus status)
{
    return status.code == TRUNNION_REFUSAL_OUT_OF_TRAVEL && status.excess * unit(status.axis) > ROUNDING;
}

/* Keeps a reason on the pins, and writes it to the log when it is new. */
static void say(TrunnionStatus status)
{
    int known = status.axis >= 0 && status.axis < TRUNNION_AXES;
    *pins->refusal = status.code;
    *pins->refusal_joint = known ? joint_of_axis[status.axis] : -1;
    *pins->refusal_excess = known ? status.excess * unit(status.axis) : status.excess * DEGREES;
    if (standing_refusal == status.code)
        return;
    standing_refusal = status.code;
    /* LinuxCNC shows its log to the operator. */
    const char *text = trunnion_refusal_text(status.code);
    if (known)
        rtapi_print_msg(RTAPI_MSG_ERR, "trunnionkins: joint %d (%c) by %.4f %s: %s\n", *pins->refusal_joint,
                        axes[status.axis].letter, *pins->refusal_excess,
                        axes[status.axis].rotary ? "deg" : "mm", text);
    else
        rtapi_print_msg(RTAPI_MSG_ERR, "trunnionkins: %s\n", text);
}

/* Counts a refusal, and says why. */
static void report(TrunnionStatus status)
{
    *pins->refusals += 1;
    say(status);
}

int kinematicsForward(const double *joint, EmcPose *pose, const KINEMATICS_FORWARD_FLAGS *forward,
                      KINEMATICS_INVERSE_FLAGS *inverse)
{
    double joints[TRUNNION_AXES], words[TRUNNION_AXES];
    (void)forward;
    (void)inverse;
    for (int axis = 0; axis < TRUNNION_AXES; axis++)
        joints[axis] = joint[joint_of_axis[axis]] / unit(axis);
    TrunnionStatus status = trunnion_forward(kinematics, *pins->tool_offset, joints, words);
    if (status.code != TRUNNION_REFUSAL_NONE) {
        report(status);
        return -1;
    }
    ZERO_EMC_POSE((*pose));
    for (int axis = 0; axis < TRUNNION_AXES; axis++) {
        /* A rotary word is its joint, to the last digit. */
        int passed = axes[axis].rotary;
        *letter(pose, axes[axis].letter) = passed ? joint[joint_of_axis[axis]] : words[axis];
    }
    return 0;
}

int kinematicsInverse(const EmcPose *pose, double *joint, const KINEMATICS_INVERSE_FLAGS *inverse,
                      KINEMATICS_FORWARD_FLAGS *forward)
{
    long long start = rtapi_get_time();
    EmcPose given = *pose;
    double joints[TRUNNION_AXES], words[TRUNNION_AXES];
    (void)inverse;
    (void)forward;
    for (int axis = 0; axis < TRUNNION_AXES; axis++)
        words[axis] = *letter(&given, axes[axis].letter) / unit(axis);
    TrunnionStatus status = trunnion_inverse(kinematics, words, joints);
    int reached = status.code == TRUNNION_REFUSAL_NONE || status.code == TRUNNION_REFUSAL_OUT_OF_TRAVEL;
    /* Plain axes are left to LinuxCNC, which judges the end of every block: between its ends no joint goes farther. It names
     * line and joint, and no remedy. With the tip a joint can leave its travel inside a block, and LinuxCNC would say so and
     * go on. */
    if (!reached || (outside(status) && !*pins->kinstype_is[TRUNNION_MODE_AXES])) {
        report(status);
        return -1;
    }
    if (outside(status))
        say(status);
    else
        standing_refusal = 0;
    for (int j = 0; j < EMCMOT_MAX_JOINTS; j++) {
        int axis = axis_of_joint[j];
        if (axis >= 0)
            joint[j] = axes[axis].rotary ? *letter(&given, axes[axis].letter) : joints[axis];
    }
    *pins->inverse_ns = (hal_s32_t)(rtapi_get_time() - start);
    if (*pins->inverse_ns > *pins->inverse_ns_max)
        *pins->inverse_ns_max = *pins->inverse_ns;
    return 0;
}

KINEMATICS_TYPE kinematicsType(void)
{
    return KINEMATICS_BOTH;
}

int kinematicsSwitchable(void)
{
    return 1;
}

int kinematicsSwitch(int kind)
{
    TrunnionStatus status = trunnion_switch(kinematics, kind, *pins->tool_offset);
    if (status.code != TRUNNION_REFUSAL_NONE) {
        report(status);
        return -1;
    }
    for (int k = 0; k < KINDS; k++)
        *pins->kinstype_is[k] = k == kind;
    return 0;
}

EXPORT_SYMBOL(kinematicsForward);
EXPORT_SYMBOL(kinematicsInverse);
EXPORT_SYMBOL(kinematicsType);
EXPORT_SYMBOL(kinematicsSwitchable);
EXPORT_SYMBOL(kinematicsSwitch);

/* Joints in the order X, Y, Z, then the rotaries by the alphabet, unless `coordinates` gives another. */
static const char *joint_letters(void)
{
    static char usual[TRUNNION_AXES + 1];
    if (coordinates)
        return coordinates;
    for (int axis = 0; axis < TRUNNION_AXES; axis++)
        usual[axis] = axes[axis].letter;
    if (usual[3] > usual[4]) {
        usual[3] = axes[4].letter;
        usual[4] = axes[3].letter;
    }
    return usual;
}

/* Gives every joint its axis. Returns -1 for a letter that the machine has not, or an axis without a joint. */
static int map_joints(const char *letters)
{
    int joints = 0;
    for (int axis = 0; axis < TRUNNION_AXES; axis++)
        joint_of_axis[axis] = -1;
    for (int j = 0; j < EMCMOT_MAX_JOINTS; j++)
        axis_of_joint[j] = -1;
    for (; *letters; letters++) {
        int axis = 0;
        if (*letters == ' ')
            continue;
        while (axis < TRUNNION_AXES && axes[axis].letter != toupper(*letters))
            axis++;
        if (axis == TRUNNION_AXES || joints == EMCMOT_MAX_JOINTS) {
            rtapi_print_msg(RTAPI_MSG_ERR, "trunnionkins: coordinates: the machine file has no axis %c\n", *letters);
            return -1;
        }
        if (joint_of_axis[axis] < 0)
            joint_of_axis[axis] = joints;
        axis_of_joint[joints++] = axis;
    }
    for (int axis = 0; axis < TRUNNION_AXES; axis++) {
        if (joint_of_axis[axis] < 0) {
            rtapi_print_msg(RTAPI_MSG_ERR, "trunnionkins: coordinates: axis %c of the machine file has no joint\n",
                            axes[axis].letter);
            return -1;
        }
    }
    return 0;
}

static int make_pins(void)
{
    int failed = 0;
    pins = hal_malloc(sizeof(struct pins));
    if (!pins)
        return -1;
    failed |= hal_pin_float_newf(HAL_IN, &pins->tool_offset, component, "trunnionkins.tool-offset");
    failed |= hal_pin_s32_newf(HAL_OUT, &pins->refusal, component, "trunnionkins.refusal");
    failed |= hal_pin_s32_newf(HAL_OUT, &pins->refusal_joint, component, "trunnionkins.refusal-joint");
    failed |= hal_pin_float_newf(HAL_OUT, &pins->refusal_excess, component, "trunnionkins.refusal-excess");
    failed |= hal_pin_u32_newf(HAL_OUT, &pins->refusals, component, "trunnionkins.refusals");
    failed |= hal_pin_s32_newf(HAL_OUT, &pins->inverse_ns, component, "trunnionkins.inverse-ns");
    failed |= hal_pin_s32_newf(HAL_IO, &pins->inverse_ns_max, component, "trunnionkins.inverse-ns-max");
    for (int k = 0; k < KINDS; k++)
        failed |= hal_pin_bit_newf(HAL_OUT, &pins->kinstype_is[k], component, "kinstype.is-%d", k);
    if (failed)
        return -1;
    *pins->refusal_joint = -1;
    return kinematicsSwitch(TRUNNION_MODE_AXES);
}

static int load(void)
{
    static char message[4000];
    kinematics = trunnion_open(machine, message, sizeof message);
    if (!kinematics) {
        rtapi_print_msg(RTAPI_MSG_ERR, "trunnionkins: %s\n", message);
        return -1;
    }
    for (int axis = 0; axis < TRUNNION_AXES; axis++)
        trunnion_axis(kinematics, axis, &axes[axis]);
    return map_joints(joint_letters());
}

int rtapi_app_main(void)
{
    component = hal_init("trunnionkins");
    if (component < 0)
        return component;
    if (load() || make_pins()) {
        trunnion_close(kinematics);
        hal_exit(component);
        return -1;
    }
    hal_ready(component);
    return 0;
}

void rtapi_app_exit(void)
{
    hal_exit(component);
    trunnion_close(kinematics);
}
