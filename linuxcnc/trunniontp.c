/* SPDX-License-Identifier: GPL-2.0-or-later
 *
 * trunniontp: trajectory planner of LinuxCNC that keeps the limits of every joint of a trunnion machine file.
 *
 *     [TRAJ]
 *     TPMOD = trunniontp machine=PATH
 *
 * This program is free software; you can redistribute it and/or modify it under the terms of the GNU General Public
 * License as published by the Free Software Foundation; either version 2 of the License, or (at your option) any later
 * version. It comes without any warranty. See README.md beside this file.
 *
 * The planning is in the library behind trunnion_rt.h, in a thread of its own. This file keeps LinuxCNC's list of blocks
 * with their ids, tags and outputs, translates degrees to radians, and plays the plan. All of it runs in the servo thread.
 */
#include <stdlib.h>
#include "rtapi.h"
#include "rtapi_app.h"
#include "rtapi_math.h"
#include "rtapi_string.h"
#include "hal.h"
#include "emcmotcfg.h"
#include "motion.h"
#include "motion_types.h"
#include "tp.h"
#include "trunnion_rt.h"

MODULE_AUTHOR("trunnion");
MODULE_DESCRIPTION("Trajectory planner within the limits of every joint");
MODULE_LICENSE("GPL");

static char *machine;
RTAPI_MP_STRING(machine, "machine file, or name of a built-in machine");

#define DEGREES (180.0 / M_PI)
/* Blocks that are known at a time; LinuxCNC's own planner has as many. */
#define BLOCKS 2048
/* Blocks that LinuxCNC may send before it looks whether the queue is full. */
#define SPARE 16
/* Lengths below which a block does not move, mm or rad. */
#define SHORTEST 1e-7
#define LINEAR 6 /* letters X Y Z, A B C, U V W */

/* What has to be true before a block may begin. */
enum gate { GATE_NONE, GATE_SPINDLE };

/* A block of LinuxCNC, with what belongs to it beside the motion. */
struct block {
    TrunnionBlock motion;
    struct state_tag_t tag;
    syncdio_t outputs;
    int id;
    int canon_type;
    unsigned char enables;
    enum gate gate;
    double speed; /* as LinuxCNC gave it */
};

struct pins {
    hal_float_t *kinematics_type; /* 0: plain axes; 1: tool-centre-point control */
    hal_float_t *tool_offset;     /* length of the tool in the spindle, mm */
    hal_float_t *axis_tolerance;  /* deviation of the rotaries at corners, degrees */
    hal_float_t *path_tolerance;  /* of G64 without P, mm */
    hal_s32_t *queue;             /* blocks that are not run */
    hal_float_t *time_ahead;      /* time until rest of what the servo thread has, s */
    hal_s32_t *cycle_ns;          /* time of the last cycle of the planner in the servo thread */
    hal_s32_t *cycle_ns_max;      /* longest time; may be set back */
    hal_float_t *plan_longest;    /* longest turn of the planning thread, s */
    hal_float_t *plan_worked;     /* time that the planning thread has worked, s */
    hal_u32_t *plan_late;         /* plans that came too late: the tool stopped */
    hal_s32_t *limit;             /* what limits the speed */
    hal_s32_t *fault;             /* reason of the last refusal */
};

static struct pins *pins;
static int component = -1;
static Trunnion *kinematics;
static TrunnionPlanner *planner;
static TrunnionAxis axes[TRUNNION_AXES];

static emcmot_status_t *status;
static emcmot_config_t *config;
static void (*write_digital)(int, char);
static void (*write_analog)(int, double);

/* Blocks by number; the numbers of the next block, of the next one that the planner gets, and of the one that runs. */
static struct block blocks[BLOCKS];
static uint32_t next_block = 1;
static uint32_t next_planned = 1;
static uint32_t running;
/* A block was refused: the program is over when the tool rests. */
static int refused;

static struct block *block_of(uint32_t number)
{
    return &blocks[number % BLOCKS];
}

static uint32_t waiting(void)
{
    return next_block - 1 - running;
}

static void letters_of(const EmcPose *pose, double *letters)
{
    const double all[TRUNNION_LETTERS] = {pose->tran.x, pose->tran.y, pose->tran.z,
                                          pose->a / DEGREES, pose->b / DEGREES, pose->c / DEGREES,
                                          pose->u, pose->v, pose->w};
    memcpy(letters, all, sizeof all);
}

static void pose_of(const double *letters, EmcPose *pose)
{
    pose->tran.x = letters[0];
    pose->tran.y = letters[1];
    pose->tran.z = letters[2];
    pose->a = letters[3] * DEGREES;
    pose->b = letters[4] * DEGREES;
    pose->c = letters[5] * DEGREES;
    pose->u = letters[6];
    pose->v = letters[7];
    pose->w = letters[8];
}

/* Length of three letters from `at`. */
static double norm(const double *letters, int at)
{
    return sqrt(letters[at] * letters[at] + letters[at + 1] * letters[at + 1] + letters[at + 2] * letters[at + 2]);
}

/* Length that a speed refers to: of X Y Z, else of U V W, else of A B C. */
static double leading_norm(const double *letters)
{
    double linear = norm(letters, 0);
    if (linear <= SHORTEST)
        linear = norm(letters, LINEAR);
    return linear > SHORTEST ? linear : norm(letters, 3) * DEGREES;
}

/* Forgets all blocks; the tool rests at `currentPos`. */
static void forget(TP_STRUCT *tp)
{
    double position[TRUNNION_LETTERS];
    letters_of(&tp->currentPos, position);
    trunnion_planner_reset(planner, position);
    tp->goalPos = tp->currentPos;
    next_planned = next_block;
    running = next_block - 1;
    refused = 0;
    tp->aborting = 0;
    tp->done = 1;
    tp->execId = 0;
    tp->motionType = 0;
    tp->depth = tp->activeDepth = 0;
}

int tpClearDIOs(TP_STRUCT *const tp)
{
    memset(&tp->syncdio, 0, sizeof tp->syncdio);
    return TP_ERR_OK;
}

int tpClear(TP_STRUCT *const tp)
{
    forget(tp);
    tp->pausing = 0;
    tp->synchronized = 0;
    if (status) {
        status->current_vel = status->requested_vel = 0.0;
        status->distance_to_go = 0.0;
        ZERO_EMC_POSE(status->dtg);
    }
    return tpClearDIOs(tp);
}

int tpInit(TP_STRUCT *const tp)
{
    tp->cycleTime = 0.0;
    tp->vLimit = tp->vMax = tp->ini_maxvel = 0.0;
    tp->aMax = tp->aLimit = tp->aMaxCartesian = 0.0;
    tp->wMax = tp->wDotMax = 0.0;
    tp->termCond = TC_TERM_COND_PARABOLIC;
    tp->tolerance = 0.0;
    tp->nextId = 0;
    tp->reverse_run = TC_DIR_FORWARD;
    ZERO_EMC_POSE(tp->currentPos);
    return tpClear(tp);
}

int tpCreate(TP_STRUCT *const tp, int size, int id)
{
    (void)id;
    if (!tp)
        return TP_ERR_FAIL;
    tp->queueSize = size <= 0 || size > BLOCKS - SPARE ? BLOCKS - SPARE : size;
    return tpInit(tp);
}

int tpSetCycleTime(TP_STRUCT *const tp, double seconds)
{
    tp->cycleTime = seconds;
    trunnion_planner_set(planner, seconds, 0.0);
    return TP_ERR_OK;
}

int tpSetVmax(TP_STRUCT *const tp, double vmax, double ini_maxvel)
{
    tp->vMax = vmax;
    tp->ini_maxvel = ini_maxvel;
    return TP_ERR_OK;
}

int tpSetVlimit(TP_STRUCT *const tp, double limit)
{
    tp->vLimit = limit < 0.0 ? 0.0 : limit;
    return TP_ERR_OK;
}

/* The joints limit the acceleration. */
int tpSetAmax(TP_STRUCT *const tp, double amax)
{
    tp->aMax = amax;
    return TP_ERR_OK;
}

int tpSetId(TP_STRUCT *const tp, int id)
{
    if (!MOTION_ID_VALID(id))
        return TP_ERR_FAIL;
    tp->nextId = id;
    return TP_ERR_OK;
}

int tpGetExecId(TP_STRUCT *const tp)
{
    return tp->execId;
}

struct state_tag_t tpGetExecTag(TP_STRUCT *const tp)
{
    return tp->execTag;
}

int tpSetTermCond(TP_STRUCT *const tp, int cond, double tolerance)
{
    if (cond < TC_TERM_COND_STOP || cond > TC_TERM_COND_TANGENT)
        return TP_ERR_FAIL;
    tp->termCond = cond;
    tp->tolerance = tolerance;
    return TP_ERR_OK;
}

int tpSetPos(TP_STRUCT *const tp, EmcPose const *const pos)
{
    double position[TRUNNION_LETTERS];
    tp->currentPos = tp->goalPos = *pos;
    letters_of(pos, position);
    if (trunnion_planner_is_done(planner))
        trunnion_planner_place(planner, position);
    else
        forget(tp);
    return TP_ERR_OK;
}

int tpSetCurrentPos(TP_STRUCT *const tp, EmcPose const *const pos)
{
    tp->currentPos = *pos;
    return TP_ERR_OK;
}

int tpAddCurrentPos(TP_STRUCT *const tp, EmcPose const *const step)
{
    EmcPose *at = &tp->currentPos;
    at->tran.x += step->tran.x;
    at->tran.y += step->tran.y;
    at->tran.z += step->tran.z;
    at->a += step->a;
    at->b += step->b;
    at->c += step->c;
    at->u += step->u;
    at->v += step->v;
    at->w += step->w;
    return TP_ERR_OK;
}

/* A gated block begins when all before it is run and its condition holds. */
static int gate_is_open(const struct block *block)
{
    if (block->gate == GATE_NONE)
        return 1;
    if (!trunnion_planner_is_done(planner))
        return 0;
    for (int spindle = 0; spindle < config->numSpindles; spindle++) {
        if (!status->spindle_status[spindle].at_speed)
            return 0;
    }
    return 1;
}

/* Hands blocks to the planner, up to the next gate that is closed. */
static void hand_over(void)
{
    while (next_planned != next_block) {
        struct block *block = block_of(next_planned);
        if (!gate_is_open(block) || !trunnion_planner_push(planner, &block->motion))
            return;
        block->gate = GATE_NONE;
        next_planned++;
    }
}

int tcqFull(TC_QUEUE_STRUCT const *const queue)
{
    (void)queue;
    return waiting() >= BLOCKS - 2 * SPARE;
}

/* Why LinuxCNC cannot have this block; 0 if it can. */
static int refusal(const TP_STRUCT *tp)
{
    if (tp->aborting || refused || waiting() >= BLOCKS - SPARE)
        return 1;
    if (tp->synchronized) {
        rtapi_print_msg(RTAPI_MSG_ERR, "trunniontp: motion in step with the spindle (G33, G33.1, G76, G95) is not planned; "
                                       "use LinuxCNC's own planner for it: take TPMOD out of [TRAJ]\n");
        return 1;
    }
    return 0;
}

/* Sets the speed of a block, which LinuxCNC gives in degrees where nothing but rotaries moves. */
static void set_speed(const TP_STRUCT *tp, struct block *block, double speed)
{
    TrunnionBlock *motion = &block->motion;
    double step[TRUNNION_LETTERS];
    for (int letter = 0; letter < TRUNNION_LETTERS; letter++)
        step[letter] = motion->end[letter] - motion->start[letter];
    /* A full circle ends where it begins. */
    int rotary = !motion->arc && norm(step, 0) <= SHORTEST && norm(step, LINEAR) <= SHORTEST;
    if (!rotary && tp->vLimit > 0.0 && speed > tp->vLimit)
        speed = tp->vLimit;
    block->speed = speed;
    motion->speed = rotary ? speed / DEGREES : speed;
}

/* Fills what lines and arcs have in common, but the speed. */
static struct block *new_block(TP_STRUCT *tp, const EmcPose *end, int canon_type, unsigned char enables, char at_speed,
                               struct state_tag_t tag)
{
    struct block *block = block_of(next_block);
    TrunnionBlock *motion = &block->motion;
    int probes = canon_type == EMC_MOTION_TYPE_PROBING;
    memset(block, 0, sizeof *block);
    block->id = tp->nextId;
    block->tag = tag;
    block->canon_type = canon_type;
    block->enables = enables;
    block->outputs = tp->syncdio;
    block->gate = at_speed ? GATE_SPINDLE : GATE_NONE;
    motion->number = next_block;
    letters_of(&tp->goalPos, motion->start);
    letters_of(end, motion->end);
    motion->kind = canon_type == EMC_MOTION_TYPE_TRAVERSE ? TRUNNION_MOVES_RAPID
        : tag.packed_flags >> GM_FLAG_FEED_INVERSE_TIME & 1 ? TRUNNION_MOVES_TIMED : TRUNNION_MOVES_FEED;
    motion->begins = at_speed || probes ? TRUNNION_BEGINS_REST
        : block->outputs.anychanged ? TRUNNION_BEGINS_MARKED : TRUNNION_BEGINS_FLOW;
    motion->ending = tp->termCond == TC_TERM_COND_STOP || probes ? TRUNNION_ENDS_STOP
        : tp->termCond == TC_TERM_COND_EXACT ? TRUNNION_ENDS_EXACT : TRUNNION_ENDS_BLEND;
    motion->tolerance = tp->tolerance > 0.0 ? tp->tolerance : *pins->path_tolerance;
    motion->mode = *pins->kinematics_type > 0.5 ? TRUNNION_MODE_TOOL_CENTER_POINT : TRUNNION_MODE_AXES;
    motion->tool_length = *pins->tool_offset;
    return block;
}

/* Appends the block that was filled. */
static int append(TP_STRUCT *tp, const EmcPose *end)
{
    tp->goalPos = *end;
    tp->done = 0;
    /* The overrides of its kind hold before it begins. */
    if (!tp->motionType)
        tp->motionType = block_of(next_block)->canon_type;
    tp->depth = (int)waiting() + 1;
    tpClearDIOs(tp);
    next_block++;
    hand_over();
    return TP_ERR_OK;
}

int tpAddLine(TP_STRUCT *const tp, EmcPose end, int canon_motion_type, double vel, double ini_maxvel, double acc,
              unsigned char enables, char atspeed, int indexrotary, struct state_tag_t tag)
{
    (void)ini_maxvel;
    (void)acc;
    if (refusal(tp))
        return TP_ERR_FAIL;
    if (indexrotary >= 0) {
        rtapi_print_msg(RTAPI_MSG_ERR, "trunniontp: a rotary that locks (LOCKING_INDEXER) is not planned\n");
        return TP_ERR_FAIL;
    }
    set_speed(tp, new_block(tp, &end, canon_motion_type, enables, atspeed, tag), vel);
    return append(tp, &end);
}

int tpAddCircle(TP_STRUCT *const tp, EmcPose end, PmCartesian center, PmCartesian normal, int turn,
                int canon_motion_type, double vel, double ini_maxvel, double acc, unsigned char enables, char atspeed,
                struct state_tag_t tag)
{
    (void)ini_maxvel;
    (void)acc;
    if (refusal(tp))
        return TP_ERR_FAIL;
    struct block *block = new_block(tp, &end, canon_motion_type, enables, atspeed, tag);
    TrunnionBlock *motion = &block->motion;
    const double middle[3] = {center.x, center.y, center.z}, axis[3] = {normal.x, normal.y, normal.z};
    motion->arc = 1;
    motion->turns = turn;
    memcpy(motion->center, middle, sizeof middle);
    memcpy(motion->normal, axis, sizeof axis);
    set_speed(tp, block, vel);
    return append(tp, &end);
}

int tpAddRigidTap(TP_STRUCT *const tp, EmcPose end, double vel, double ini_maxvel, double acc, unsigned char enables,
                  double scale, struct state_tag_t tag)
{
    (void)tp;
    (void)end;
    (void)vel;
    (void)ini_maxvel;
    (void)acc;
    (void)enables;
    (void)scale;
    (void)tag;
    rtapi_print_msg(RTAPI_MSG_ERR, "trunniontp: rigid tapping (G33.1) is not planned; use LinuxCNC's own planner for it: "
                                   "take TPMOD out of [TRAJ]\n");
    return TP_ERR_FAIL;
}

int tpSetSpindleSync(TP_STRUCT *const tp, int spindle, double sync, int mode)
{
    tp->spindle.spindle_num = spindle;
    tp->synchronized = sync != 0.0;
    tp->velocity_mode = mode;
    tp->uu_per_rev = sync;
    return TP_ERR_OK;
}

int tpPause(TP_STRUCT *const tp)
{
    tp->pausing = 1;
    return TP_ERR_OK;
}

int tpResume(TP_STRUCT *const tp)
{
    tp->pausing = 0;
    return TP_ERR_OK;
}

int tpAbort(TP_STRUCT *const tp)
{
    if (!tp->aborting && !tp->done) {
        /* What the planner has not got it will not get. */
        tp->aborting = 1;
        next_planned = next_block;
        trunnion_planner_abort(planner);
    }
    refused = 0;
    return tpClearDIOs(tp);
}

int tpGetMotionType(TP_STRUCT *const tp)
{
    return tp->motionType;
}

int tpGetPos(TP_STRUCT const *const tp, EmcPose *const pos)
{
    *pos = tp->currentPos;
    return TP_ERR_OK;
}

int tpIsDone(TP_STRUCT *const tp)
{
    return tp->done;
}

int tpIsMoving(TP_STRUCT const *const tp)
{
    return !tp->done;
}

int tpQueueDepth(TP_STRUCT *const tp)
{
    return tp->depth;
}

int tpActiveDepth(TP_STRUCT *const tp)
{
    return tp->activeDepth;
}

int tpSetAout(TP_STRUCT *const tp, unsigned char index, double start, double end)
{
    (void)end;
    if (index >= EMCMOT_MAX_AIO)
        return TP_ERR_FAIL;
    tp->syncdio.anychanged = 1;
    tp->syncdio.aio_mask |= (iomask_t)1 << index;
    tp->syncdio.aios[index] = start;
    return TP_ERR_OK;
}

int tpSetDout(TP_STRUCT *const tp, int index, unsigned char start, unsigned char end)
{
    (void)end;
    if (index < 0 || index >= EMCMOT_MAX_DIO)
        return TP_ERR_FAIL;
    tp->syncdio.anychanged = 1;
    tp->syncdio.dio_mask |= (iomask_t)1 << index;
    tp->syncdio.dios[index] = start ? 1 : -1;
    return TP_ERR_OK;
}

/* The plan runs forwards only. */
int tpSetRunDir(TP_STRUCT *const tp, tc_direction_t dir)
{
    (void)tp;
    if (dir == TC_DIR_FORWARD)
        return TP_ERR_OK;
    rtapi_print_msg(RTAPI_MSG_ERR, "trunniontp: reverse run is not planned; use LinuxCNC's own planner for it: take TPMOD out "
                                   "of [TRAJ]\n");
    return TP_ERR_FAIL;
}

/* Sets the outputs that belong to the beginning of a block. */
static void write_outputs(const syncdio_t *outputs)
{
    if (!outputs->anychanged)
        return;
    for (int index = 0; index < config->numDIO; index++) {
        if (outputs->dio_mask >> index & 1)
            write_digital(index, outputs->dios[index] > 0);
    }
    for (int index = 0; index < config->numAIO; index++) {
        if (outputs->aio_mask >> index & 1)
            write_analog(index, outputs->aios[index]);
    }
}

void tpToggleDIOs(TC_STRUCT *const tc)
{
    write_outputs(&tc->syncdio);
}

/* Begins all blocks up to a number: blocks without motion are passed on the way. */
static void begin_up_to(TP_STRUCT *tp, uint32_t number)
{
    while ((int32_t)(number - running) > 0) {
        const struct block *block = block_of(++running);
        write_outputs(&block->outputs);
        tp->execId = block->id;
        tp->execTag = block->tag;
        tp->motionType = block->canon_type;
        status->enables_queued = block->enables;
    }
}

/* Overrides of the feed and of rapid moves. LinuxCNC combines all switches for the kind of move that runs. */
static void overrides(const TP_STRUCT *tp, double *feed, double *rapid)
{
    int runs_rapid = tp->motionType == EMC_MOTION_TYPE_TRAVERSE;
    *feed = *rapid = 1.0;
    if (status->enables_queued & FS_ENABLED) {
        *feed = status->feed_scale;
        *rapid = status->rapid_scale;
    }
    double own = runs_rapid ? *rapid : *feed;
    double net = tp->pausing || tp->aborting ? 0.0 : status->net_feed_scale;
    if (net <= 0.0 || own <= 0.0) {
        *feed = *rapid = 0.0;
        return;
    }
    /* Adaptive feed is a factor of both. */
    double others = net / own;
    *feed *= others;
    *rapid = *rapid * others > 1.0 ? 1.0 : *rapid * others;
    /* The kind that does not run holds when its turn comes. */
    if (*feed <= 0.0)
        *feed = 1e-3;
    if (*rapid <= 0.0)
        *rapid = 1e-3;
}

/* Says which block is refused and why; the program ends when the tool rests. */
static void report(TrunnionFault fault)
{
    const struct block *block = block_of(fault.block);
    const char *text = trunnion_refusal_text(fault.code);
    int line = block->tag.fields[GM_FIELD_LINE_NUMBER];
    *pins->fault = fault.code;
    refused = 1;
    if (fault.code == TRUNNION_REFUSAL_NO_AXIS && fault.axis >= 0 && fault.axis < TRUNNION_LETTERS)
        rtapi_print_msg(RTAPI_MSG_ERR, "trunniontp: line %d: letter %c: %s\n", line, "XYZABCUVW"[fault.axis], text);
    else if (fault.axis >= 0 && fault.axis < TRUNNION_AXES)
        rtapi_print_msg(RTAPI_MSG_ERR, "trunniontp: line %d: axis %c by %.4f %s: %s\n", line, axes[fault.axis].letter,
                        fault.excess * (axes[fault.axis].rotary ? DEGREES : 1.0),
                        axes[fault.axis].rotary ? "deg" : "mm", text);
    else
        rtapi_print_msg(RTAPI_MSG_ERR, "trunniontp: line %d: %s\n", line, text);
}

/* Tells LinuxCNC where the tool is in the block. */
static void tell(const TP_STRUCT *tp, const TrunnionSample *sample)
{
    const struct block *block = block_of(running);
    double left[TRUNNION_LETTERS];
    int moves = !tp->done;
    for (int letter = 0; letter < TRUNNION_LETTERS; letter++)
        left[letter] = moves ? block->motion.end[letter] - sample->position[letter] : 0.0;
    pose_of(left, &status->dtg);
    status->distance_to_go = moves ? leading_norm(left) : 0.0;
    status->current_vel = leading_norm(sample->velocity);
    status->requested_vel = moves ? block->speed * status->net_feed_scale : 0.0;
    status->tcqlen = (unsigned int)tp->depth;
}

/* The state of the plan, on the pins. */
static void show(const TP_STRUCT *tp)
{
    TrunnionPlannerState state;
    trunnion_planner_state(planner, &state);
    *pins->queue = tp->depth;
    *pins->time_ahead = state.ahead;
    *pins->plan_longest = state.longest_turn;
    *pins->plan_worked = state.worked;
    *pins->plan_late = state.late;
    *pins->limit = (hal_s32_t)state.limit;
}

/* Ends what is at rest: a program at its end, an abort, a refused block. */
static void end_at_rest(TP_STRUCT *tp, const TrunnionSample *sample)
{
    if (tp->aborting) {
        if (!trunnion_planner_is_aborting(planner) && sample->rests)
            forget(tp);
        return;
    }
    if (!sample->done || next_planned != next_block)
        return;
    if (refused) {
        /* The task looks at this, and ends the program. */
        status->commandStatus = EMCMOT_COMMAND_BAD_EXEC;
        status->motionFlag |= EMCMOT_MOTION_ERROR_BIT;
        tp->goalPos = tp->currentPos;
        running = next_block - 1;
    }
    begin_up_to(tp, next_block - 1);
    tp->done = 1;
    tp->execId = 0;
    tp->motionType = 0;
    status->enables_queued = status->enables_new;
}

int tpRunCycle(TP_STRUCT *const tp, long period)
{
    long long start = rtapi_get_time();
    TrunnionSample sample;
    TrunnionFault fault;
    double feed, rapid;
    (void)period;
    trunnion_planner_set(planner, 0.0, *pins->axis_tolerance / DEGREES);
    hand_over();
    overrides(tp, &feed, &rapid);
    trunnion_planner_cycle(planner, feed, rapid, &sample);
    if (!sample.rests)
        begin_up_to(tp, sample.block);
    pose_of(sample.position, &tp->currentPos);
    while (trunnion_planner_fault(planner, &fault))
        report(fault);
    end_at_rest(tp, &sample);
    tp->depth = (int)waiting() + !tp->done;
    tp->activeDepth = !sample.rests;
    tell(tp, &sample);
    show(tp);
    *pins->cycle_ns = (hal_s32_t)(rtapi_get_time() - start);
    if (*pins->cycle_ns > *pins->cycle_ns_max)
        *pins->cycle_ns_max = *pins->cycle_ns;
    return TP_ERR_OK;
}

void tpMotFunctions(void (*pDioWrite)(int, char), void (*pAioWrite)(int, double), void (*pSetRotaryUnlock)(int, int),
                    int (*pGetRotaryUnlock)(int), double (*paxis_get_vel_limit)(int),
                    double (*paxis_get_acc_limit)(int))
{
    (void)pSetRotaryUnlock;
    (void)pGetRotaryUnlock;
    (void)paxis_get_vel_limit;
    (void)paxis_get_acc_limit;
    write_digital = pDioWrite;
    write_analog = pAioWrite;
}

void tpMotData(emcmot_status_t *pstatus, emcmot_config_t *pconfig)
{
    status = pstatus;
    config = pconfig;
}

EXPORT_SYMBOL(tpMotFunctions);
EXPORT_SYMBOL(tpMotData);
EXPORT_SYMBOL(tpAbort);
EXPORT_SYMBOL(tpActiveDepth);
EXPORT_SYMBOL(tpAddCircle);
EXPORT_SYMBOL(tpAddLine);
EXPORT_SYMBOL(tpAddRigidTap);
EXPORT_SYMBOL(tpClear);
EXPORT_SYMBOL(tpCreate);
EXPORT_SYMBOL(tpGetExecId);
EXPORT_SYMBOL(tpGetExecTag);
EXPORT_SYMBOL(tpGetMotionType);
EXPORT_SYMBOL(tpGetPos);
EXPORT_SYMBOL(tpIsDone);
EXPORT_SYMBOL(tpPause);
EXPORT_SYMBOL(tpQueueDepth);
EXPORT_SYMBOL(tpResume);
EXPORT_SYMBOL(tpRunCycle);
EXPORT_SYMBOL(tpSetAmax);
EXPORT_SYMBOL(tpSetAout);
EXPORT_SYMBOL(tpSetCycleTime);
EXPORT_SYMBOL(tpSetDout);
EXPORT_SYMBOL(tpSetId);
EXPORT_SYMBOL(tpSetPos);
EXPORT_SYMBOL(tpSetRunDir);
EXPORT_SYMBOL(tpSetSpindleSync);
EXPORT_SYMBOL(tpSetTermCond);
EXPORT_SYMBOL(tpSetVlimit);
EXPORT_SYMBOL(tpSetVmax);
EXPORT_SYMBOL(tcqFull);

static int make_pins(void)
{
    int failed = 0;
    pins = hal_malloc(sizeof(struct pins));
    if (!pins)
        return -1;
    failed |= hal_pin_float_newf(HAL_IN, &pins->kinematics_type, component, "trunniontp.kinematics-type");
    failed |= hal_pin_float_newf(HAL_IN, &pins->tool_offset, component, "trunniontp.tool-offset");
    failed |= hal_pin_float_newf(HAL_IN, &pins->axis_tolerance, component, "trunniontp.axis-tolerance");
    failed |= hal_pin_float_newf(HAL_IN, &pins->path_tolerance, component, "trunniontp.path-tolerance");
    failed |= hal_pin_s32_newf(HAL_OUT, &pins->queue, component, "trunniontp.queue");
    failed |= hal_pin_float_newf(HAL_OUT, &pins->time_ahead, component, "trunniontp.time-ahead");
    failed |= hal_pin_s32_newf(HAL_OUT, &pins->cycle_ns, component, "trunniontp.cycle-ns");
    failed |= hal_pin_s32_newf(HAL_IO, &pins->cycle_ns_max, component, "trunniontp.cycle-ns-max");
    failed |= hal_pin_float_newf(HAL_OUT, &pins->plan_longest, component, "trunniontp.plan-longest");
    failed |= hal_pin_float_newf(HAL_OUT, &pins->plan_worked, component, "trunniontp.plan-worked");
    failed |= hal_pin_u32_newf(HAL_OUT, &pins->plan_late, component, "trunniontp.plan-late");
    failed |= hal_pin_s32_newf(HAL_OUT, &pins->limit, component, "trunniontp.binding-limit");
    failed |= hal_pin_s32_newf(HAL_OUT, &pins->fault, component, "trunniontp.fault");
    if (failed)
        return -1;
    *pins->axis_tolerance = 0.1;
    *pins->path_tolerance = 0.1;
    return 0;
}

/* The planner keeps the limits of the machine file: where those of a joint in the INI file are narrower LinuxCNC would stop
 * the machine inside a block. The script that starts LinuxCNC names its INI file in the environment. */
static int fits_the_ini_file(void)
{
    static char message[4000];
    const char *ini = getenv("INI_FILE_NAME");
    if (!ini)
        return 1;
    int differences = trunnion_ini(kinematics, ini, message, sizeof message);
    for (char *line = strtok(message, "\n"); line; line = strtok(NULL, "\n"))
        rtapi_print_msg(RTAPI_MSG_ERR, "trunniontp: %s does not fit the machine file: %s\n", ini, line);
    return differences == 0;
}

static int load(void)
{
    static char message[4000];
    kinematics = trunnion_open(machine, message, sizeof message);
    if (kinematics && !fits_the_ini_file())
        return -1;
    if (kinematics)
        planner = trunnion_planner_start(kinematics, BLOCKS, 0.001, message, sizeof message);
    if (!planner) {
        rtapi_print_msg(RTAPI_MSG_ERR, "trunniontp: %s\n", message);
        return -1;
    }
    for (int axis = 0; axis < TRUNNION_AXES; axis++)
        trunnion_axis(kinematics, axis, &axes[axis]);
    return 0;
}

static void unload(void)
{
    trunnion_planner_stop(planner);
    trunnion_close(kinematics);
}

int rtapi_app_main(void)
{
    component = hal_init("trunniontp");
    if (component < 0)
        return component;
    if (load() || make_pins()) {
        unload();
        hal_exit(component);
        return -1;
    }
    hal_ready(component);
    return 0;
}

void rtapi_app_exit(void)
{
    hal_exit(component);
    unload();
}
