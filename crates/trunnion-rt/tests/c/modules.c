/* Two kinematics modules of LinuxCNC side by side, without LinuxCNC: the few HAL and RTAPI functions that they need are
 * here. Usage:
 *
 *     modules STOCK.so TRUNNIONKINS.so MACHINE [PIN=VALUE ...]     compares forward and inverse on random positions
 *     modules - TRUNNIONKINS.so MACHINE [coordinates=LETTERS]      loads alone, and prints the joints of one pose
 *
 * Exit codes: 0 done; 2 a module cannot be loaded. The comparison prints the largest differences and median times. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

typedef struct { double x, y, z, a, b, c, u, v, w; } Pose;
typedef struct {
    int (*forward)(const double *, Pose *, const unsigned long *, unsigned long *);
    int (*inverse)(const Pose *, double *, const unsigned long *, unsigned long *);
    int (*change)(int);
} Module;

enum { PINS = 100, POSITIONS = 20000, JOINTS = 16 };
static char pin_names[PINS][64];
static double pin_values[PINS];
static int pin_count;

static int new_pin(void **pin, const char *format, va_list list)
{
    if (pin_count == PINS)
        return -1;
    vsnprintf(pin_names[pin_count], sizeof pin_names[0], format, list);
    *pin = &pin_values[pin_count++];
    return 0;
}

#define NEW_PIN(name) \
    int name(int direction, void **pin, int component, const char *format, ...) \
    { \
        va_list list; \
        (void)direction; \
        (void)component; \
        va_start(list, format); \
        int failed = new_pin(pin, format, list); \
        va_end(list); \
        return failed; \
    }
NEW_PIN(hal_pin_float_newf)
NEW_PIN(hal_pin_bit_newf)
NEW_PIN(hal_pin_s32_newf)
NEW_PIN(hal_pin_u32_newf)

static int plain_pin(const char *name, void **pin)
{
    if (pin_count == PINS)
        return -1;
    snprintf(pin_names[pin_count], sizeof pin_names[0], "%s", name);
    *pin = &pin_values[pin_count++];
    return 0;
}

#define PLAIN_PIN(name) \
    int name(const char *pin_name, int direction, void **pin, int component) \
    { \
        (void)direction; \
        (void)component; \
        return plain_pin(pin_name, pin); \
    }
PLAIN_PIN(hal_pin_float_new)
PLAIN_PIN(hal_pin_bit_new)
PLAIN_PIN(hal_pin_s32_new)
int hal_init(const char *name) { (void)name; return 1; }
int hal_exit(int component) { (void)component; return 0; }
int hal_ready(int component) { (void)component; return 0; }
void *hal_malloc(long size) { return calloc(1, (size_t)size); }
void rtapi_print(const char *format, ...) { (void)format; }

void rtapi_print_msg(int level, const char *format, ...)
{
    va_list list;
    (void)level;
    va_start(list, format);
    vprintf(format, list);
    va_end(list);
}

long long rtapi_get_time(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return 1000000000LL * now.tv_sec + now.tv_nsec;
}

static void set_pins(const char *ending, double value)
{
    for (int k = 0; k < pin_count; k++) {
        size_t length = strlen(pin_names[k]), tail = strlen(ending);
        if (length >= tail && !strcmp(pin_names[k] + length - tail, ending))
            pin_values[k] = value;
    }
}

static void *symbol(void *library, const char *name)
{
    void *found = dlsym(library, name);
    if (!found) {
        puts(dlerror());
        exit(2);
    }
    return found;
}

static Module load(const char *path, const char *machine, const char *letters)
{
    Module module;
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (!library) {
        puts(dlerror());
        exit(2);
    }
    if (machine)
        **(char ***)symbol(library, "rtapi_info_address_machine") = (char *)machine;
    if (letters)
        **(char ***)symbol(library, "rtapi_info_address_coordinates") = (char *)letters;
    int (*start)(void);
    *(void **)&start = symbol(library, "rtapi_app_main");
    *(void **)&module.forward = symbol(library, "kinematicsForward");
    *(void **)&module.inverse = symbol(library, "kinematicsInverse");
    *(void **)&module.change = symbol(library, "kinematicsSwitch");
    if (start())
        exit(2);
    return module;
}

static double between(double low, double high)
{
    static uint64_t state = 88172645463325253u;
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    return low + (high - low) * (double)(state >> 11) * 0x1p-53;
}

static double larger(double worst, const double *a, const double *b, int count)
{
    for (int k = 0; k < count; k++) {
        double difference = fabs(a[k] - b[k]);
        worst = difference > worst || isnan(difference) ? difference : worst;
    }
    return worst;
}

static int by_size(const void *a, const void *b)
{
    const double *x = a, *y = b;
    return (*x > *y) - (*x < *y);
}

static double median(double *times)
{
    qsort(times, POSITIONS, sizeof *times, by_size);
    return times[POSITIONS / 2];
}

static int compare(const Module *stock, const Module *ours)
{
    static double stock_time[POSITIONS], our_time[POSITIONS];
    double forward = 0, inverse = 0;
    unsigned long flags = 0;
    for (int k = 0; k < POSITIONS; k++) {
        double joints[JOINTS] = {0}, back[2][JOINTS] = {{0}};
        Pose pose[2];
        for (int j = 0; j < 5; j++)
            joints[j] = j < 3 ? between(-400, 400) : between(-170, 170);
        memset(pose, 0, sizeof pose);
        if (k % 100 == 0) {
            set_pins(".tool-offset", between(0, 200));
            ours->change(1);
        }
        stock->forward(joints, &pose[0], &flags, &flags);
        ours->forward(joints, &pose[1], &flags, &flags);
        forward = larger(forward, &pose[0].x, &pose[1].x, 9);
        double start = (double)rtapi_get_time();
        stock->inverse(&pose[0], back[0], &flags, &flags);
        double between_both = (double)rtapi_get_time();
        ours->inverse(&pose[0], back[1], &flags, &flags);
        our_time[k] = (double)rtapi_get_time() - between_both;
        stock_time[k] = between_both - start;
        inverse = larger(inverse, back[0], back[1], 5);
    }
    printf("forward %.3g mm, inverse %.3g mm; inverse takes %.0f ns, stock %.0f ns\n", forward, inverse,
           median(our_time), median(stock_time));
    return !(forward < 1e-8 && inverse < 1e-8);
}

static int alone(const Module *ours)
{
    unsigned long flags = 0;
    double joints[JOINTS];
    Pose pose = {10, 20, 30, 4, 5, 6, 0, 0, 0};
    for (int j = 0; j < JOINTS; j++)
        joints[j] = -1;
    if (ours->inverse(&pose, joints, &flags, &flags))
        return 1;
    for (int j = 0; j < 7; j++)
        printf("%g ", joints[j]);
    puts("");
    return ours->change(7) == 0;
}

int main(int count, char **arguments)
{
    if (count < 4)
        return 2;
    const char *letters = NULL;
    for (int k = 4; k < count; k++)
        if (!strncmp(arguments[k], "coordinates=", 12))
            letters = arguments[k] + 12;
    Module ours = load(arguments[2], arguments[3], letters);
    if (!strcmp(arguments[1], "-"))
        return alone(&ours);
    Module stock = load(arguments[1], NULL, NULL);
    for (int k = 4; k < count; k++) {
        char *value = strchr(arguments[k], '=');
        if (value) {
            *value = 0;
            set_pins(arguments[k], atof(value + 1));
        }
    }
    return compare(&stock, &ours);
}
