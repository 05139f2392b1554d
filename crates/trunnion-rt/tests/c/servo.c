/* A servo cycle in C: opens a machine, forbids the process all system calls but write and exit, and runs kinematics.
 * Usage: servo MACHINE. Exit codes: 0 done; 1 a wrong result; 3 no machine. Killed: a call asked the system. */
#define _GNU_SOURCE
#include "trunnion_rt.h"
#include <linux/seccomp.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

enum { CALLS = 200000, TIMED = 20001 };

static double between(uint64_t *state, double low, double high)
{
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    return low + (high - low) * (double)(*state >> 11) * 0x1p-53;
}

static void joints_inside(const TrunnionAxis *axes, uint64_t *state, double *joints)
{
    for (int k = 0; k < TRUNNION_AXES; k++) {
        double low = isfinite(axes[k].low) ? axes[k].low : -10.0;
        double high = isfinite(axes[k].high) ? axes[k].high : 10.0;
        joints[k] = between(state, low, high);
    }
}

/* One cycle: joints to words and back, and the pose to joints. Returns the number of wrong results. */
static int cycle(Trunnion *machine, const double *joints, double length)
{
    double words[TRUNNION_AXES], back[TRUNNION_AXES], pose[TRUNNION_POSE], near[TRUNNION_AXES];
    int wrong = trunnion_switch(machine, TRUNNION_MODE_TOOL_CENTER_POINT, length).code != 0;
    wrong += trunnion_forward(machine, length, joints, words).code != 0;
    wrong += trunnion_inverse(machine, words, back).code != 0;
    wrong += trunnion_pose(machine, length, joints, pose).code != 0;
    memcpy(near, joints, sizeof near);
    wrong += trunnion_nearest(machine, length, pose, near, near).code != 0;
    for (int k = 0; k < TRUNNION_AXES; k++)
        wrong += !(fabs(back[k] - joints[k]) < 1e-7) + !(fabs(near[k] - joints[k]) < 1e-7);
    return wrong;
}

/* Refusals: a NaN, a direction without length, null pointers, an unknown mode. Returns the number of wrong results. */
static int refusals(Trunnion *machine, const double *joints)
{
    double out[TRUNNION_POSE], none[TRUNNION_POSE] = {0};
    double words[TRUNNION_AXES] = {NAN, 0, 0, 0, 0};
    int wrong = trunnion_inverse(machine, words, out).code != TRUNNION_REFUSAL_NOT_FINITE;
    wrong += trunnion_nearest(machine, 0, none, joints, out).code != TRUNNION_REFUSAL_NOT_FINITE;
    wrong += trunnion_inverse(NULL, joints, out).code != TRUNNION_REFUSAL_INTERNAL;
    wrong += trunnion_forward(machine, 0, joints, NULL).code != TRUNNION_REFUSAL_INTERNAL;
    wrong += trunnion_switch(machine, 2, 0).code != TRUNNION_REFUSAL_UNKNOWN_MODE;
    wrong += strlen(trunnion_refusal_text(TRUNNION_REFUSAL_LENGTH_CHANGED)) < 10;
    return wrong;
}

static double nanoseconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return 1e9 * (double)now.tv_sec + (double)now.tv_nsec;
}

static int by_size(const void *a, const void *b)
{
    const double *x = a, *y = b;
    return (*x > *y) - (*x < *y);
}

/* Writes the median and worst time of an inverse in this process, which no real-time kernel protects. */
static void timed(Trunnion *machine, const TrunnionAxis *axes, const char *name)
{
    static double times[TIMED];
    uint64_t state = 99;
    double joints[TRUNNION_AXES], words[TRUNNION_AXES];
    trunnion_switch(machine, TRUNNION_MODE_TOOL_CENTER_POINT, 100);
    for (int k = 0; k < TIMED; k++) {
        joints_inside(axes, &state, joints);
        trunnion_forward(machine, 100, joints, words);
        double start = nanoseconds();
        trunnion_inverse(machine, words, joints);
        times[k] = nanoseconds() - start;
    }
    qsort(times, TIMED, sizeof *times, by_size);
    printf("%s: inverse %.0f ns median, %.0f ns worst of %d\n", name, times[TIMED / 2], times[TIMED - 1], TIMED);
}

int main(int count, char **arguments)
{
    char message[2000];
    Trunnion *machine = trunnion_open(count > 1 ? arguments[1] : NULL, message, sizeof message);
    if (!machine) {
        puts(message);
        return 3;
    }
    TrunnionAxis axes[TRUNNION_AXES];
    for (size_t k = 0; k < TRUNNION_AXES; k++)
        if (trunnion_axis(machine, k, &axes[k]).code || axes[k].rotary != (k > 2))
            return 1;
    timed(machine, axes, arguments[1]);
    fflush(stdout);

    int strict = prctl(PR_SET_SECCOMP, SECCOMP_MODE_STRICT) == 0;
    int wrong = 0;
    uint64_t state = 7;
    double joints[TRUNNION_AXES];
    for (int k = 0; k < CALLS / 4; k++) {
        joints_inside(axes, &state, joints);
        wrong += cycle(machine, joints, k % 300);
    }
    wrong += refusals(machine, joints);
    static const char lax[] = "the system does not forbid calls here: nothing is proved about them\n";
    if (!strict && write(1, lax, sizeof lax - 1) < 0)
        wrong++;
    /* The plain exit of a thread: the library's own asks for more than is allowed now. */
    syscall(SYS_exit, wrong != 0);
    return 1;
}
