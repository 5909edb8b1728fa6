/* The functions of FMI 3.0.2 for model exchange and co-simulation, around fmu_core.c; types and names are those of the
   standard, Functional Mock-up Interface 3.0, sections 2.2, 3.2 and 4.2. */

#include <stdbool.h>
#include <stdint.h>

typedef void *fmi3Instance, *fmi3InstanceEnvironment, *fmi3FMUState;
typedef uint32_t fmi3ValueReference;
typedef double fmi3Float64;
typedef bool fmi3Boolean, fmi3Clock;
typedef const char *fmi3String;
typedef uint8_t fmi3Byte;
typedef const fmi3Byte *fmi3Binary;
typedef enum { fmi3OK, fmi3Warning, fmi3Discard, fmi3Error, fmi3Fatal } fmi3Status;
typedef enum { fmi3Independent, fmi3Constant, fmi3Fixed, fmi3Tunable, fmi3Discrete, fmi3Dependent } fmi3DependencyKind;
typedef enum { fmi3IntervalNotYetKnown, fmi3IntervalUnchanged, fmi3IntervalChanged } fmi3IntervalQualifier;
typedef void (*fmi3LogMessageCallback)(fmi3InstanceEnvironment, fmi3Status, fmi3String, fmi3String);
typedef void (*fmi3IntermediateUpdateCallback)(fmi3InstanceEnvironment, fmi3Float64, fmi3Boolean, fmi3Boolean, fmi3Boolean,
                                               fmi3Boolean, fmi3Boolean *, fmi3Float64 *);
typedef void (*fmi3ClockUpdateCallback)(fmi3InstanceEnvironment);
typedef void (*fmi3PreemptionCallback)(void);

#ifdef _WIN32
#define FMI __declspec(dllexport)
#else
#define FMI __attribute__((visibility("default")))
#endif

/* An instance as FMI 3.0 sees it. */
typedef struct {
  fmu_instance core; /* first, so that a pointer to one is a pointer to the other */
  fmi3LogMessageCallback log;
  fmi3IntermediateUpdateCallback update;
  bool early_return;
} fmu_instance3;

static const fmi3Status fmu_status[] = {fmi3OK, fmi3Warning, fmi3Discard, fmi3Error};

static void fmu_to_logger(fmu_instance *f, int severity, const char *category, const char *text) {
  fmi3LogMessageCallback log = ((fmu_instance3 *)f)->log;
  if (log && (severity != FMU_OK || f->logging)) log(f->environment, fmu_status[severity], category, text);
}

static fmu_instance *fmu_allowed(fmi3Instance c, int phases, const char *function) {
  fmu_instance *f = c;
  if (f && !(f->now.phase & phases)) {
    fmu_tell(f, FMU_ERROR, "logStatusError", "%s cannot be called now.", function);
    return 0;
  }
  return f;
}

#define ALLOW(phases, function) \
  fmu_instance *f = fmu_allowed(c, phases, #function); \
  if (!f) return fmi3Error

static fmi3Status fmu_done(int status) { return fmu_status[status]; }

enum { BEFORE_AND_IN_CONTINUOUS = FMU_INITIALIZING | FMU_CONTINUOUS | FMU_EVENTS | FMU_TERMINATED };

FMI const char *fmi3GetVersion(void) { return "3.0"; }

FMI fmi3Status fmi3SetDebugLogging(fmi3Instance c, fmi3Boolean on, size_t count, const fmi3String categories[]) {
  ALLOW(ALIVE, fmi3SetDebugLogging);
  (void)count, (void)categories;
  f->logging = on;
  return fmi3OK;
}

static fmi3Instance fmu_instantiate(fmi3String name, fmi3String token, fmi3String folder, fmi3Boolean logging,
                                    fmi3InstanceEnvironment environment, fmi3LogMessageCallback log, int co_simulation) {
  fmu_instance3 *f3 = calloc(1, sizeof *f3);
  fmu_instance *f = &f3->core;
  if (!f3) return 0;
  f->environment = environment;
  f->tell = fmu_to_logger;
  f->logging = logging;
  f3->log = log;
  if (!token || strcmp(token, MODEL_TOKEN)) {
    fmu_tell(f, FMU_ERROR, "logStatusError", "%s: the instantiation token is not that of this model description.",
             MODEL_NAME);
    free(f3);
    return 0;
  }
  return fmu_create(f, name, folder, co_simulation);
}

FMI fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String folder, fmi3Boolean visible,
                                              fmi3Boolean logging, fmi3InstanceEnvironment environment,
                                              fmi3LogMessageCallback log) {
  (void)visible;
  return fmu_instantiate(name, token, folder, logging, environment, log, 0);
}

/* A point within a communication step, offered to the importer; 1 where it asks to stop there. */
static int fmu_offer(fmu_instance *f) {
  fmu_instance3 *f3 = (fmu_instance3 *)f;
  fmi3Boolean stop = false;
  fmi3Float64 when = f->now.t;
  f->now.phase = FMU_INTERMEDIATE;
  f3->update(f->environment, f->now.t, false, true, true, f3->early_return, &stop, &when);
  f->now.phase = FMU_STEPPING;
  return f3->early_return && stop;
}

FMI fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String folder, fmi3Boolean visible,
                                             fmi3Boolean logging, fmi3Boolean event_mode, fmi3Boolean early_return,
                                             const fmi3ValueReference required[], size_t count,
                                             fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                             fmi3IntermediateUpdateCallback update) {
  fmu_instance3 *f3;
  (void)visible, (void)required;
  if (event_mode) {
    if (log)
      log(environment, fmi3Error, "logStatusError", MODEL_NAME ": it has no event mode in co-simulation; events are dealt "
          "with inside of fmi3DoStep.");
    return 0;
  }
  f3 = fmu_instantiate(name, token, folder, logging, environment, log, 1);
  if (!f3) return 0;
  f3->update = update;
  f3->early_return = early_return;
  if (update && (early_return || count)) f3->core.intermediate = fmu_offer;
  return f3;
}

FMI fmi3Instance fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String folder,
                                                   fmi3Boolean visible, fmi3Boolean logging,
                                                   fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                                   fmi3ClockUpdateCallback clock, fmi3PreemptionCallback lock,
                                                   fmi3PreemptionCallback unlock) {
  (void)name, (void)token, (void)folder, (void)visible, (void)logging, (void)clock, (void)lock, (void)unlock;
  if (log) log(environment, fmi3Error, "logStatusError", MODEL_NAME ": there is no scheduled execution.");
  return 0;
}

FMI void fmi3FreeInstance(fmi3Instance c) {
  if (c && fmu_allowed(c, AT_REST, "fmi3FreeInstance")) fmu_free(c);
}

FMI fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean tolerance_defined, fmi3Float64 tolerance,
                                           fmi3Float64 start, fmi3Boolean stop_defined, fmi3Float64 stop) {
  ALLOW(FMU_INSTANTIATED, fmi3EnterInitializationMode);
  (void)tolerance_defined, (void)tolerance, (void)stop_defined, (void)stop;
  if (fmu_refuse_time(f, "startTime", start)) return fmi3Error;
  f->now.t = f->now.t_start = start;
  f->now.phase = FMU_INITIALIZING;
  fmu_moved(f);
  return fmi3OK;
}

FMI fmi3Status fmi3ExitInitializationMode(fmi3Instance c) {
  int status;
  ALLOW(FMU_INITIALIZING, fmi3ExitInitializationMode);
  status = fmu_solve(f);
  f->now.phase = f->co_simulation ? FMU_STEPPING : FMU_EVENTS;
  if (status == FMU_OK) status = fmu_begin(f);
  if (status >= FMU_DISCARD) f->now.phase = FMU_FAILED;
  return fmu_done(status == FMU_DISCARD ? FMU_ERROR : status);
}

FMI fmi3Status fmi3EnterEventMode(fmi3Instance c) {
  ALLOW(FMU_CONTINUOUS | FMU_EVENTS, fmi3EnterEventMode);
  f->now.phase = FMU_EVENTS;
  return fmi3OK;
}

FMI fmi3Status fmi3Terminate(fmi3Instance c) {
  ALLOW(FMU_RUNNING & AT_REST, fmi3Terminate);
  f->now.phase = FMU_TERMINATED;
  return fmi3OK;
}

FMI fmi3Status fmi3Reset(fmi3Instance c) {
  ALLOW(AT_REST, fmi3Reset);
  return fmu_done(fmu_reset(f));
}

/* --- variables ----------------------------------------------------------------------------------------------------- */

FMI fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference r[], size_t count, fmi3Float64 values[],
                              size_t lengths) {
  ALLOW(ALIVE, fmi3GetFloat64);
  return lengths < count ? fmi3Error : fmu_done(fmu_get_all(f, r, count, values));
}

FMI fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference r[], size_t count, const fmi3Float64 values[],
                              size_t lengths) {
  ALLOW(SETTABLE, fmi3SetFloat64);
  return lengths < count ? fmi3Error : fmu_done(fmu_set_all(f, r, count, values));
}

/* There are only variables of type Float64. */
#define NO_VARIABLES(name, type) \
  FMI fmi3Status name(fmi3Instance c, const fmi3ValueReference r[], size_t count, type values[], size_t lengths) { \
    ALLOW(ALIVE, name); \
    (void)values, (void)lengths; \
    return count ? fmu_status[fmu_unknown(f, r[0], "used by " #name)] : fmi3OK; \
  }
NO_VARIABLES(fmi3GetFloat32, float)
NO_VARIABLES(fmi3GetInt8, int8_t)
NO_VARIABLES(fmi3GetUInt8, uint8_t)
NO_VARIABLES(fmi3GetInt16, int16_t)
NO_VARIABLES(fmi3GetUInt16, uint16_t)
NO_VARIABLES(fmi3GetInt32, int32_t)
NO_VARIABLES(fmi3GetUInt32, uint32_t)
NO_VARIABLES(fmi3GetInt64, int64_t)
NO_VARIABLES(fmi3GetUInt64, uint64_t)
NO_VARIABLES(fmi3GetBoolean, fmi3Boolean)
NO_VARIABLES(fmi3GetString, fmi3String)
NO_VARIABLES(fmi3SetFloat32, const float)
NO_VARIABLES(fmi3SetInt8, const int8_t)
NO_VARIABLES(fmi3SetUInt8, const uint8_t)
NO_VARIABLES(fmi3SetInt16, const int16_t)
NO_VARIABLES(fmi3SetUInt16, const uint16_t)
NO_VARIABLES(fmi3SetInt32, const int32_t)
NO_VARIABLES(fmi3SetUInt32, const uint32_t)
NO_VARIABLES(fmi3SetInt64, const int64_t)
NO_VARIABLES(fmi3SetUInt64, const uint64_t)
NO_VARIABLES(fmi3SetBoolean, const fmi3Boolean)
NO_VARIABLES(fmi3SetString, const fmi3String)

/* A function of something that a model does not have. */
#define NOTHING(name, ...) \
  FMI fmi3Status name(fmi3Instance c, const fmi3ValueReference r[], size_t count, __VA_ARGS__) { \
    ALLOW(ALIVE, name); \
    return count ? fmu_status[fmu_unknown(f, r[0], "used by " #name)] : fmi3OK; \
  }
NOTHING(fmi3GetBinary, size_t sizes[], fmi3Binary values[], size_t lengths)
NOTHING(fmi3SetBinary, const size_t sizes[], const fmi3Binary values[], size_t lengths)
NOTHING(fmi3GetClock, fmi3Clock values[])
NOTHING(fmi3SetClock, const fmi3Clock values[])
NOTHING(fmi3GetIntervalDecimal, fmi3Float64 intervals[], fmi3IntervalQualifier qualifiers[])
NOTHING(fmi3GetIntervalFraction, uint64_t counters[], uint64_t resolutions[], fmi3IntervalQualifier qualifiers[])
NOTHING(fmi3GetShiftDecimal, fmi3Float64 shifts[])
NOTHING(fmi3GetShiftFraction, uint64_t counters[], uint64_t resolutions[])
NOTHING(fmi3SetIntervalDecimal, const fmi3Float64 intervals[])
NOTHING(fmi3SetIntervalFraction, const uint64_t counters[], const uint64_t resolutions[])
NOTHING(fmi3SetShiftDecimal, const fmi3Float64 shifts[])
NOTHING(fmi3SetShiftFraction, const uint64_t counters[], const uint64_t resolutions[])
NOTHING(fmi3GetOutputDerivatives, const int32_t orders[], fmi3Float64 values[], size_t lengths)

#define REFUSED(name, reason, ...) \
  FMI fmi3Status name(__VA_ARGS__) { \
    ALLOW(ALIVE, name); \
    fmu_tell(f, FMU_ERROR, "logStatusError", #name ": " reason); \
    return fmi3Error; \
  }
REFUSED(fmi3GetNumberOfVariableDependencies, "the dependencies stand in the model description.", fmi3Instance c,
        fmi3ValueReference r, size_t *count)
REFUSED(fmi3GetVariableDependencies, "the dependencies stand in the model description.", fmi3Instance c,
        fmi3ValueReference r, size_t elements[], fmi3ValueReference independents[], size_t independent_elements[],
        fmi3DependencyKind kinds[], size_t count)
REFUSED(fmi3GetAdjointDerivative, "there are directional derivatives, and no adjoint ones.", fmi3Instance c,
        const fmi3ValueReference unknown[], size_t unknowns, const fmi3ValueReference known[], size_t knowns,
        const fmi3Float64 seed[], size_t seeds, fmi3Float64 sensitivity[], size_t sensitivities)
REFUSED(fmi3EnterConfigurationMode, "there are no structural parameters.", fmi3Instance c)
REFUSED(fmi3ExitConfigurationMode, "there are no structural parameters.", fmi3Instance c)
REFUSED(fmi3EvaluateDiscreteStates, "there are no clocked states.", fmi3Instance c)
REFUSED(fmi3EnterStepMode, "there is no event mode in co-simulation.", fmi3Instance c)
REFUSED(fmi3ActivateModelPartition, "there is no scheduled execution.", fmi3Instance c, fmi3ValueReference r,
        fmi3Float64 time)

/* --- saved states -------------------------------------------------------------------------------------------------- */

FMI fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState *state) {
  ALLOW(AT_REST, fmi3GetFMUState);
  if (!*state) *state = malloc(fmu_saved_size(f));
  if (!*state) return fmi3Error;
  fmu_save(f, *state);
  return fmi3OK;
}

FMI fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState state) {
  ALLOW(AT_REST, fmi3SetFMUState);
  return state ? fmu_done(fmu_restore(f, state)) : fmi3Error;
}

FMI fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState *state) {
  (void)c;
  if (!state) return fmi3OK;
  free(*state);
  *state = 0;
  return fmi3OK;
}

FMI fmi3Status fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState state, size_t *size) {
  ALLOW(ALIVE, fmi3SerializedFMUStateSize);
  (void)state;
  *size = fmu_saved_size(f);
  return fmi3OK;
}

FMI fmi3Status fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState state, fmi3Byte bytes[], size_t size) {
  ALLOW(ALIVE, fmi3SerializeFMUState);
  return fmu_done(fmu_to_bytes(f, state, (char *)bytes, size));
}

FMI fmi3Status fmi3DeserializeFMUState(fmi3Instance c, const fmi3Byte bytes[], size_t size, fmi3FMUState *state) {
  ALLOW(ALIVE, fmi3DeserializeFMUState);
  return fmu_done(fmu_from_bytes(f, (const char *)bytes, size, state));
}

FMI fmi3Status fmi3GetDirectionalDerivative(fmi3Instance c, const fmi3ValueReference unknown[], size_t unknowns,
                                            const fmi3ValueReference known[], size_t knowns, const fmi3Float64 seed[],
                                            size_t seeds, fmi3Float64 sensitivity[], size_t sensitivities) {
  ALLOW(FMU_INITIALIZING | FMU_RUNNING | FMU_TERMINATED, fmi3GetDirectionalDerivative);
  if (seeds < knowns || sensitivities < unknowns) return fmi3Error;
  return fmu_done(fmu_derivative(f, unknown, unknowns, known, knowns, seed, sensitivity));
}

/* --- model exchange ------------------------------------------------------------------------------------------------ */

FMI fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean *again, fmi3Boolean *terminate, fmi3Boolean *nominals,
                                        fmi3Boolean *values, fmi3Boolean *time_defined, fmi3Float64 *time) {
  int changed = 0, status;
  double next;
  ALLOW(FMU_EVENTS, fmi3UpdateDiscreteStates);
  status = fmu_update(f, &changed);
  next = fmu_next_sample(f);
  *again = *terminate = *nominals = false;
  *values = changed;
  *time_defined = isfinite(next);
  *time = isfinite(next) ? next : 0.0;
  return fmu_done(status);
}

FMI fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance c) {
  ALLOW(FMU_EVENTS, fmi3EnterContinuousTimeMode);
  if (f->co_simulation) return fmi3Error;
  f->now.phase = FMU_CONTINUOUS;
  return fmi3OK;
}

FMI fmi3Status fmi3CompletedIntegratorStep(fmi3Instance c, fmi3Boolean final, fmi3Boolean *enter, fmi3Boolean *terminate) {
  ALLOW(FMU_CONTINUOUS, fmi3CompletedIntegratorStep);
  (void)final;
  *enter = *terminate = false;
  return fmu_done(fmu_completed(f));
}

FMI fmi3Status fmi3SetTime(fmi3Instance c, fmi3Float64 time) {
  ALLOW(FMU_CONTINUOUS | FMU_EVENTS, fmi3SetTime);
  if (fmu_refuse_time(f, "time", time)) return fmi3Error;
  if (time != f->now.t) {
    f->now.t = time;
    fmu_moved(f);
  }
  return fmi3OK;
}

FMI fmi3Status fmi3SetContinuousStates(fmi3Instance c, const fmi3Float64 x[], size_t count) {
  ALLOW(FMU_CONTINUOUS | FMU_EVENTS, fmi3SetContinuousStates);
  return fmu_done(fmu_set_states(f, x, count));
}

FMI fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance c, fmi3Float64 values[], size_t count) {
  int status;
  ALLOW(BEFORE_AND_IN_CONTINUOUS, fmi3GetContinuousStateDerivatives);
  if (count != NX) return fmi3Error;
  status = fmu_evaluate(f);
  if (status == FMU_OK) memcpy(values, f->engine->ode, sizeof(double) * NX);
  return fmu_done(status);
}

FMI fmi3Status fmi3GetEventIndicators(fmi3Instance c, fmi3Float64 values[], size_t count) {
  ALLOW(BEFORE_AND_IN_CONTINUOUS, fmi3GetEventIndicators);
  return count == EVENTS ? fmu_done(EVENTS ? fmu_shown_indicators(f, values) : FMU_OK) : fmi3Error;
}

FMI fmi3Status fmi3GetContinuousStates(fmi3Instance c, fmi3Float64 x[], size_t count) {
  int status = FMU_OK;
  ALLOW(BEFORE_AND_IN_CONTINUOUS, fmi3GetContinuousStates);
  if (count != NX) return fmi3Error;
  if (f->now.phase == FMU_INITIALIZING) status = fmu_solve(f);
  memcpy(x, f->now.x, sizeof(double) * NX);
  return fmu_done(status);
}

FMI fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance c, fmi3Float64 values[], size_t count) {
  ALLOW(ALIVE, fmi3GetNominalsOfContinuousStates);
  if (count != NX) return fmi3Error;
  memcpy(values, fmu_x_nominal, sizeof(double) * NX);
  return fmi3OK;
}

FMI fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance c, size_t *count) {
  ALLOW(ALIVE, fmi3GetNumberOfEventIndicators);
  *count = EVENTS;
  return fmi3OK;
}

FMI fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance c, size_t *count) {
  ALLOW(ALIVE, fmi3GetNumberOfContinuousStates);
  *count = NX;
  return fmi3OK;
}

/* --- co-simulation ------------------------------------------------------------------------------------------------- */

FMI fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 t, fmi3Float64 h, fmi3Boolean no_set_state, fmi3Boolean *event,
                          fmi3Boolean *terminate, fmi3Boolean *early, fmi3Float64 *last) {
  int status, stopped = 0;
  ALLOW(FMU_STEPPING, fmi3DoStep);
  (void)no_set_state;
  *event = *terminate = *early = false;
  status = fmu_check_step(f, t, h);
  if (status == FMU_OK) status = fmu_do_step(f, h, &stopped);
  *early = stopped && f->now.t < t + h - 1e-7 * h;
  *last = f->now.t;
  if (status >= FMU_DISCARD) f->now.phase = FMU_FAILED;
  return fmu_done(status >= FMU_DISCARD ? FMU_ERROR : status);
}
