/* A pitch and torque controller of the NREL 5 MW turbine as a co-simulation FMU; FMI 2.0 or, with -DVERSION=3, 3.0.

   The laws of components/servo, written again: J. Jonkman et al., NREL/TP-500-38060 (2009), chapter 7. One control
   sample when initialised, one in each doStep. `trouble` = 1 fails, 2 is fatal, 3 gives no number, 4 (3.0) asks for the end, from `trouble_time`;
   5 crashes, 6 exits, 7 hangs, 8 prints 10 MB, 12 aborts with words then; 9 crashes when it is terminated, 10 when it is freed, 11 hangs when it
   is terminated, 13 exits when it is initialised. The environment variable TEST_FMU_CRASHES makes it crash when it is instantiated.
   `mode` (whole number) and `enabled` come back as `mode_out` and `active`. FMI 3.0 only: array_out[i] = (i + 1)
   array_in[i], row by row of 2 x 2. */
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#if VERSION == 3
#include "fmi3Functions.h"
#define REAL fmi3Float64
#else
#include "fmi2Functions.h"
#define REAL fmi2Real
#endif

enum { SPEED, PITCH, TORQUE, PERIOD, KP, KI, PITCH_START, TORQUE_START, SPEED_START, TROUBLE_TIME, COUNTED, REALS };
enum { TROUBLE = 100, MODE = 101, SAMPLES = 102, ENABLED = 200, ACTIVE = 201, ARRAY_IN = 300, ARRAY_OUT = 301 };

typedef struct {
    double real[REALS], filtered, summed, held, torque, time, in[4];
    int trouble, mode, samples, enabled, ready;
#if VERSION == 3
    fmi3LogMessageCallback log;
    fmi3InstanceEnvironment environment;
#else
    const fmi2CallbackFunctions *functions;
#endif
} Unit;

static int instances; /* of this loaded library */

static double larger(double a, double b, double width) {
    double near = fmin(fmax((a - b) / width, -1), 1);
    return fmax(a, b) + width * (3 + 6 * near * near - pow(near, 4) - 8 * fmax(near, -near)) / 16;
}
static double smaller(double a, double b, double width) { return -larger(-a, -b, width); }

static double torque_law(double speed, double pitch) {
    const double rpm = 3.14159265358979323846 / 30, rated = 43093.55, k = 0.0255764 / (rpm * rpm), width = 0.01 * rated;
    const double synchronous = 1161.963 * rpm / 1.1;
    double slope15 = k * 871 * rpm * 871 * rpm / (871 * rpm - 670 * rpm), slope25 = rated / (1161.963 * rpm - synchronous);
    double below = larger(smaller(slope15 * (speed - 670 * rpm), k * speed * speed, width), 0, width);
    double law = smaller(larger(below, slope25 * (speed - synchronous), width), rated, width);
    double degree = 3.14159265358979323846 / 180, way = fmin(fmax((pitch - degree) / degree + 0.5, 0), 1);
    return fmin(law + (rated - law) * way * way * (3 - 2 * way), 47402.91);
}

static double held(double value, double low, double high) { return fmin(fmax(value, low), high); }

static void control(Unit *unit) {
    const double pi = 3.14159265358979323846, doubling = 0.1099965, high = pi / 2;
    double speed = unit->real[SPEED] * pi / 30, period = unit->real[PERIOD], forget = exp(-2 * pi * 0.25 * period);
    double gain = 1 / (1 + unit->held / doubling), error, step = 8 * pi / 180 * period;
    unit->filtered = forget * unit->filtered + (1 - forget) * speed;
    error = unit->filtered - 1173.7 * pi / 30;
    unit->summed = held(unit->summed + unit->real[KI] * error * period, 0, high / gain);
    unit->held = held(held(gain * (unit->real[KP] * error + unit->summed), 0, high), unit->held - step, unit->held + step);
    step = 15000 * period;
    unit->torque = held(torque_law(unit->filtered, unit->held), unit->torque - step, unit->torque + step);
    unit->real[PITCH] = unit->held * 180 / pi;
    unit->real[TORQUE] = unit->torque / 1000;
    unit->samples++;
}

static void crash(void) {
    raise(SIGSEGV);
}

static void begin(Unit *unit) {
    if (unit->trouble == 13) exit(0);
    const double doubling = 0.1099965;
    unit->held = unit->real[PITCH_START];
    unit->summed = unit->held * (1 + unit->held / doubling);
    unit->filtered = unit->real[SPEED_START];
    unit->torque = unit->real[TORQUE_START];
    control(unit);
    unit->ready = 1;
}

static Unit *make(void) {
    if (getenv("TEST_FMU_CRASHES")) crash();
    Unit *unit = calloc(1, sizeof *unit);
    unit->real[PERIOD] = 0.0125;
    unit->real[KP] = 0.006275604;
    unit->real[KI] = 0.0008965149;
    unit->real[TROUBLE_TIME] = 1e9;
    unit->real[COUNTED] = ++instances;
    unit->enabled = 1;
    return unit;
}

/* 0: go on, else the status to return */
static int step(Unit *unit, double from, double length) {
    unit->time = from + length;
    if (unit->time >= unit->real[TROUBLE_TIME] - 1e-9 && unit->trouble == 1) return 3;
    if (unit->time >= unit->real[TROUBLE_TIME] - 1e-9 && unit->trouble == 2) return 4;
    if (unit->time >= unit->real[TROUBLE_TIME] - 1e-9) {
        if (unit->trouble == 5) crash();
        if (unit->trouble == 6) exit(0);
        if (unit->trouble == 7) sleep(100);
        if (unit->trouble == 8) for (int i = 0; i < 200000; i++) printf("%06d: fifty bytes of words that nobody reads...\n", i);
        if (unit->trouble == 12) {
            printf("the table has 0 rows\n");
            fflush(stdout);
            abort();
        }
    }
    control(unit);
    if (unit->time >= unit->real[TROUBLE_TIME] - 1e-9 && unit->trouble == 3) unit->real[PITCH] = NAN;
    return 0;
}

static int terminate(Unit *unit) {
    if (unit->trouble == 9) crash();
    if (unit->trouble == 11) sleep(100);
    return 0;
}

static void release(Unit *unit) {
    if (unit->trouble == 10) crash();
    instances--;
    free(unit);
}

static Unit *copy(const Unit *unit) {
    Unit *made = malloc(sizeof *made);
    return memcpy(made, unit, sizeof *made);
}

/* What is of an instance, and not of its state, stays. */
static void take(Unit *unit, const Unit *state) {
    Unit old = *unit;
    *unit = *state;
#if VERSION == 3
    unit->log = old.log;
    unit->environment = old.environment;
#else
    unit->functions = old.functions;
#endif
}

#if VERSION == 3
fmi3Instance fmi3InstantiateCoSimulation(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible, fmi3Boolean logging, fmi3Boolean events,
    fmi3Boolean early, const fmi3ValueReference wanted[], size_t n, fmi3InstanceEnvironment environment,
    fmi3LogMessageCallback log, fmi3IntermediateUpdateCallback update) {
    (void)name, (void)resources, (void)visible, (void)logging, (void)events, (void)early, (void)wanted, (void)n, (void)update;
    if (strcmp(token, "fowtlib-test-controller")) return NULL;
    Unit *unit = make();
    unit->log = log;
    unit->environment = environment;
    return unit;
}
void fmi3FreeInstance(fmi3Instance c) { release(c); }
const char *fmi3GetVersion(void) { return fmi3Version; }
fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean defined, fmi3Float64 tolerance, fmi3Float64 start,
                                       fmi3Boolean ends, fmi3Float64 end) {
    (void)defined, (void)tolerance, (void)ends, (void)end;
    ((Unit *)c)->time = start;
    return fmi3OK;
}
fmi3Status fmi3ExitInitializationMode(fmi3Instance c) { begin(c); return fmi3OK; }
fmi3Status fmi3Terminate(fmi3Instance c) { return terminate(c); }
fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Float64 values[], size_t count) {
    Unit *unit = c;
    if (n == 1 && vr[0] == ARRAY_OUT) {
        for (size_t i = 0; i < count; i++) values[i] = (double)(i + 1) * unit->in[i];
        return count == 4 ? fmi3OK : fmi3Error;
    }
    for (size_t i = 0; i < n; i++) values[i] = unit->real[vr[i]];
    return fmi3OK;
}
fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Float64 values[], size_t count) {
    Unit *unit = c;
    if (n == 1 && vr[0] == ARRAY_IN) {
        if (count != 4) return fmi3Error;
        memcpy(unit->in, values, sizeof unit->in);
        return fmi3OK;
    }
    for (size_t i = 0; i < n; i++) unit->real[vr[i]] = values[i];
    return fmi3OK;
}
fmi3Status fmi3GetInt32(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Int32 values[], size_t count) {
    Unit *unit = c;
    (void)count;
    for (size_t i = 0; i < n; i++)
        values[i] = vr[i] == TROUBLE ? unit->trouble : vr[i] == SAMPLES ? unit->samples : unit->mode;
    return fmi3OK;
}
fmi3Status fmi3SetInt32(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Int32 values[], size_t count) {
    Unit *unit = c;
    (void)count;
    for (size_t i = 0; i < n; i++) *(vr[i] == TROUBLE ? &unit->trouble : &unit->mode) = values[i];
    return fmi3OK;
}
fmi3Status fmi3GetBoolean(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Boolean values[], size_t count) {
    (void)vr, (void)count;
    for (size_t i = 0; i < n; i++) values[i] = ((Unit *)c)->enabled != 0;
    return fmi3OK;
}
fmi3Status fmi3SetBoolean(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Boolean values[], size_t count) {
    (void)vr, (void)count;
    for (size_t i = 0; i < n; i++) ((Unit *)c)->enabled = values[i];
    return fmi3OK;
}
fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 from, fmi3Float64 length, fmi3Boolean fixed, fmi3Boolean *event,
                      fmi3Boolean *terminate, fmi3Boolean *early, fmi3Float64 *reached) {
    Unit *unit = c;
    (void)fixed;
    int status = step(unit, from, length);
    *event = *early = false;
    *terminate = unit->trouble == 4 && unit->time >= unit->real[TROUBLE_TIME] - 1e-9;
    *reached = unit->time;
    if (status) unit->log(unit->environment, status, "error", "the pitch drive is gone");
    return status;
}
fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState *state) { *state = copy(c); return fmi3OK; }
fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState state) { take(c, state); return fmi3OK; }
fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState *state) { (void)c; free(*state); *state = NULL; return fmi3OK; }
fmi3Status fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState state, size_t *size) {
    (void)c, (void)state;
    *size = sizeof(Unit);
    return fmi3OK;
}
fmi3Status fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState state, fmi3Byte bytes[], size_t size) {
    (void)c;
    memcpy(bytes, state, size);
    return fmi3OK;
}
fmi3Status fmi3DeserializeFMUState(fmi3Instance c, const fmi3Byte bytes[], size_t size, fmi3FMUState *state) {
    (void)c;
    if (size != sizeof(Unit)) return fmi3Error;
    *state = copy((const Unit *)bytes);
    return fmi3OK;
}
#else
fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) { *state = copy(c); return fmi2OK; }
fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) { take(c, state); return fmi2OK; }
fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) { (void)c; free(*state); *state = NULL; return fmi2OK; }
fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size) {
    (void)c, (void)state;
    *size = sizeof(Unit);
    return fmi2OK;
}
fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
    (void)c;
    memcpy(bytes, state, size);
    return fmi2OK;
}
fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state) {
    (void)c;
    if (size != sizeof(Unit)) return fmi2Error;
    *state = copy((const Unit *)bytes);
    return fmi2OK;
}
const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }
fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging) {
    (void)name, (void)resources, (void)visible, (void)logging;
    if (type != fmi2CoSimulation || strcmp(guid, "fowtlib-test-controller")) return NULL;
    Unit *unit = make();
    unit->functions = functions;
    return unit;
}
void fmi2FreeInstance(fmi2Component c) { release(c); }
fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[]) {
    (void)c, (void)on, (void)n, (void)categories;
    return fmi2OK;
}
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean defined, fmi2Real tolerance, fmi2Real start, fmi2Boolean ends,
                               fmi2Real end) {
    (void)defined, (void)tolerance, (void)ends, (void)end;
    ((Unit *)c)->time = start;
    return fmi2OK;
}
fmi2Status fmi2EnterInitializationMode(fmi2Component c) { (void)c; return fmi2OK; }
fmi2Status fmi2ExitInitializationMode(fmi2Component c) { begin(c); return fmi2OK; }
fmi2Status fmi2Terminate(fmi2Component c) { return terminate(c); }
fmi2Status fmi2Reset(fmi2Component c) { (void)c; return fmi2OK; }
fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[]) {
    for (size_t i = 0; i < n; i++) value[i] = ((Unit *)c)->real[vr[i]];
    return fmi2OK;
}
fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[]) {
    for (size_t i = 0; i < n; i++) ((Unit *)c)->real[vr[i]] = value[i];
    return fmi2OK;
}
static int *whole(Unit *unit, unsigned reference) {
    return reference == TROUBLE ? &unit->trouble : reference == MODE ? &unit->mode : reference == SAMPLES ? &unit->samples
           : &unit->enabled;
}
fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Integer value[]) {
    for (size_t i = 0; i < n; i++) value[i] = *whole(c, vr[i]);
    return fmi2OK;
}
fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer value[]) {
    for (size_t i = 0; i < n; i++) *whole(c, vr[i]) = value[i];
    return fmi2OK;
}
fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Boolean value[]) {
    return fmi2GetInteger(c, vr, n, value);
}
fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Boolean value[]) {
    return fmi2SetInteger(c, vr, n, value);
}
fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2String value[]) {
    (void)c, (void)vr, (void)n, (void)value;
    return fmi2Error;
}
fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2String value[]) {
    (void)c, (void)vr, (void)n, (void)value;
    return fmi2Error;
}
fmi2Status fmi2DoStep(fmi2Component c, fmi2Real from, fmi2Real length, fmi2Boolean fixed) {
    Unit *unit = c;
    (void)fixed;
    int status = step(unit, from, length);
    if (status) unit->functions->logger(unit->functions->componentEnvironment, "unit", status, "error", "the pitch drive is gone");
    return status;
}
#endif
