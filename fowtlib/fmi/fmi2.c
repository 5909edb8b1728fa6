/* The functions of FMI 2.0.5 for model exchange and co-simulation, around fmu_core.c; types and names are those of the
   standard, Functional Mock-up Interface 2.0, sections 2.1, 3.2 and 4.2. */

typedef void *fmi2Component, *fmi2ComponentEnvironment, *fmi2FMUstate;
typedef unsigned int fmi2ValueReference;
typedef double fmi2Real;
typedef int fmi2Integer, fmi2Boolean;
typedef const char *fmi2String;
typedef char fmi2Byte;
typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;
typedef enum { fmi2ModelExchange, fmi2CoSimulation } fmi2Type;
typedef enum { fmi2DoStepStatus, fmi2PendingStatus, fmi2LastSuccessfulTime, fmi2Terminated } fmi2StatusKind;

typedef struct {
  void (*logger)(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String, ...);
  void *(*allocateMemory)(size_t, size_t);
  void (*freeMemory)(void *);
  void (*stepFinished)(fmi2ComponentEnvironment, fmi2Status);
  fmi2ComponentEnvironment componentEnvironment;
} fmi2CallbackFunctions;

typedef struct {
  fmi2Boolean newDiscreteStatesNeeded, terminateSimulation, nominalsOfContinuousStatesChanged;
  fmi2Boolean valuesOfContinuousStatesChanged, nextEventTimeDefined;
  fmi2Real nextEventTime;
} fmi2EventInfo;

#ifdef _WIN32
#define FMI __declspec(dllexport)
#else
#define FMI __attribute__((visibility("default")))
#endif

/* An instance as FMI 2.0 sees it. */
typedef struct {
  fmu_instance core; /* first, so that a pointer to one is a pointer to the other */
  fmi2CallbackFunctions functions; /* a copy: those of the importer may be gone after fmi2Instantiate */
} fmu_instance2;

static const fmi2Status fmu_status[] = {fmi2OK, fmi2Warning, fmi2Discard, fmi2Error};

/* A % in a message would be taken for a form by the logger. */
static void fmu_to_logger(fmu_instance *f, int severity, const char *category, const char *text) {
  const fmi2CallbackFunctions *functions = &((fmu_instance2 *)f)->functions;
  char escaped[2 * TEXT], *to = escaped;
  if (!functions->logger || (severity == FMU_OK && !f->logging)) return;
  for (; *text && to < escaped + sizeof escaped - 3; text++) {
    if (*text == '%') *to++ = '%';
    *to++ = *text;
  }
  *to = 0;
  functions->logger(functions->componentEnvironment, f->name ? f->name : "", fmu_status[severity], category, escaped);
}

/* The instance of a call, null unless it is allowed now. */
static fmu_instance *fmu_allowed(fmi2Component c, int phases, const char *function) {
  fmu_instance *f = c;
  if (f && !(f->now.phase & phases)) {
    fmu_tell(f, FMU_ERROR, "logStatusError", "%s cannot be called now.", function);
    return 0;
  }
  return f;
}

#define ALLOW(phases, function) \
  fmu_instance *f = fmu_allowed(c, phases, #function); \
  if (!f) return fmi2Error

static fmi2Status fmu_done(int status) { return fmu_status[status]; }

/* The path of a file: URI, in place of the URI. */
static void fmu_path_of_uri(const char *uri, char *path, size_t size) {
  size_t used = 0;
  if (!strncmp(uri, "file:///", 8)) uri += 7;
  else if (!strncmp(uri, "file://localhost/", 17)) uri += 16;
  else if (!strncmp(uri, "file:/", 6)) uri += 5;
#ifdef _WIN32
  if (uri[0] == '/' && uri[1] == '/' && uri[2] && uri[3] == ':') uri++; /* file://C:/ is often met */
  if (uri[0] == '/' && uri[1] && uri[2] == ':') uri++;
#endif
  for (; *uri && used + 1 < size; used++) {
    unsigned code;
    if (uri[0] == '%' && uri[1] && uri[2] && sscanf(uri + 1, "%2x", &code) == 1) {
      path[used] = (char)code;
      uri += 3;
    } else path[used] = *uri++;
  }
  path[used] = 0;
}

FMI const char *fmi2GetTypesPlatform(void) { return "default"; }
FMI const char *fmi2GetVersion(void) { return "2.0"; }

FMI fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t count, const fmi2String categories[]) {
  ALLOW(ALIVE, fmi2SetDebugLogging);
  (void)count;
  (void)categories;
  f->logging = on;
  return fmi2OK;
}

FMI fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String token, fmi2String location,
                                  const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging) {
  fmu_instance2 *f2 = calloc(1, sizeof *f2);
  fmu_instance *f = &f2->core;
  char folder[4000] = "";
  (void)visible;
  if (!f2) return 0;
  if (functions) f2->functions = *functions;
  f->tell = fmu_to_logger;
  f->logging = logging;
  if (location) fmu_path_of_uri(location, folder, sizeof folder);
  if (!token || strcmp(token, MODEL_TOKEN)) {
    fmu_tell(f, FMU_ERROR, "logStatusError", "%s: the guid is not that of this model description.", MODEL_NAME);
    free(f2);
    return 0;
  }
  return fmu_create(f, name, location ? folder : 0, type == fmi2CoSimulation);
}

FMI void fmi2FreeInstance(fmi2Component c) { fmu_free(c); }

FMI fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean tolerance_defined, fmi2Real tolerance, fmi2Real start,
                                   fmi2Boolean stop_defined, fmi2Real stop) {
  ALLOW(FMU_INSTANTIATED, fmi2SetupExperiment);
  (void)tolerance_defined, (void)tolerance, (void)stop_defined, (void)stop;
  if (fmu_refuse_time(f, "startTime", start)) return fmi2Error;
  f->now.t = f->now.t_start = start;
  fmu_moved(f);
  return fmi2OK;
}

FMI fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
  ALLOW(FMU_INSTANTIATED, fmi2EnterInitializationMode);
  f->now.phase = FMU_INITIALIZING;
  fmu_moved(f);
  return fmi2OK;
}

FMI fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
  int status;
  ALLOW(FMU_INITIALIZING, fmi2ExitInitializationMode);
  status = fmu_solve(f);
  f->now.phase = f->co_simulation ? FMU_STEPPING : FMU_EVENTS;
  if (status == FMU_OK) status = fmu_begin(f);
  if (status >= FMU_DISCARD) f->now.phase = FMU_FAILED;
  return fmu_done(status == FMU_DISCARD ? FMU_ERROR : status);
}

FMI fmi2Status fmi2Terminate(fmi2Component c) {
  ALLOW(FMU_RUNNING & AT_REST, fmi2Terminate);
  f->now.phase = FMU_TERMINATED;
  return fmi2OK;
}

FMI fmi2Status fmi2Reset(fmi2Component c) {
  ALLOW(AT_REST, fmi2Reset);
  return fmu_done(fmu_reset(f));
}

FMI fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference r[], size_t count, fmi2Real values[]) {
  ALLOW(ALIVE, fmi2GetReal);
  return fmu_done(fmu_get_all(f, r, count, values));
}

FMI fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference r[], size_t count, const fmi2Real values[]) {
  ALLOW(SETTABLE, fmi2SetReal);
  return fmu_done(fmu_set_all(f, r, count, values));
}

/* There are only variables of type Real. */
#define NO_VARIABLES(name, type) \
  FMI fmi2Status name(fmi2Component c, const fmi2ValueReference r[], size_t count, type values[]) { \
    ALLOW(ALIVE, name); \
    (void)values; \
    return count ? fmu_status[fmu_unknown(f, r[0], "used by " #name)] : fmi2OK; \
  }
NO_VARIABLES(fmi2GetInteger, fmi2Integer)
NO_VARIABLES(fmi2GetBoolean, fmi2Boolean)
NO_VARIABLES(fmi2GetString, fmi2String)
NO_VARIABLES(fmi2SetInteger, const fmi2Integer)
NO_VARIABLES(fmi2SetBoolean, const fmi2Boolean)
NO_VARIABLES(fmi2SetString, const fmi2String)

/* --- saved states -------------------------------------------------------------------------------------------------- */

FMI fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
  ALLOW(AT_REST, fmi2GetFMUstate);
  if (!*state) *state = malloc(fmu_saved_size(f));
  if (!*state) return fmi2Error;
  fmu_save(f, *state);
  return fmi2OK;
}

FMI fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
  ALLOW(AT_REST, fmi2SetFMUstate);
  return state ? fmu_done(fmu_restore(f, state)) : fmi2Error;
}

FMI fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) {
  (void)c;
  if (!state) return fmi2OK;
  free(*state);
  *state = 0;
  return fmi2OK;
}

FMI fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size) {
  ALLOW(ALIVE, fmi2SerializedFMUstateSize);
  (void)state;
  *size = fmu_saved_size(f);
  return fmi2OK;
}

FMI fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
  ALLOW(ALIVE, fmi2SerializeFMUstate);
  return fmu_done(fmu_to_bytes(f, state, (char *)bytes, size));
}

FMI fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state) {
  ALLOW(ALIVE, fmi2DeSerializeFMUstate);
  return fmu_done(fmu_from_bytes(f, (const char *)bytes, size, state));
}

FMI fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[], size_t unknowns,
                                            const fmi2ValueReference known[], size_t knowns, const fmi2Real seed[],
                                            fmi2Real sensitivity[]) {
  ALLOW(FMU_INITIALIZING | FMU_RUNNING | FMU_TERMINATED, fmi2GetDirectionalDerivative);
  return fmu_done(fmu_derivative(f, unknown, unknowns, known, knowns, seed, sensitivity));
}

/* --- model exchange ------------------------------------------------------------------------------------------------ */

FMI fmi2Status fmi2EnterEventMode(fmi2Component c) {
  ALLOW(FMU_CONTINUOUS | FMU_EVENTS, fmi2EnterEventMode);
  f->now.phase = FMU_EVENTS;
  return fmi2OK;
}

FMI fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *info) {
  int changed = 0, status;
  double next;
  ALLOW(FMU_EVENTS, fmi2NewDiscreteStates);
  memset(info, 0, sizeof *info);
  status = fmu_update(f, &changed);
  next = fmu_next_sample(f);
  info->valuesOfContinuousStatesChanged = changed;
  info->nextEventTimeDefined = isfinite(next);
  info->nextEventTime = isfinite(next) ? next : 0.0;
  return fmu_done(status);
}

FMI fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c) {
  ALLOW(FMU_EVENTS, fmi2EnterContinuousTimeMode);
  f->now.phase = FMU_CONTINUOUS;
  return fmi2OK;
}

FMI fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean final, fmi2Boolean *enter, fmi2Boolean *terminate) {
  ALLOW(FMU_CONTINUOUS, fmi2CompletedIntegratorStep);
  (void)final;
  *enter = *terminate = 0;
  return fmu_done(fmu_completed(f));
}

FMI fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time) {
  ALLOW(FMU_CONTINUOUS | FMU_EVENTS, fmi2SetTime);
  if (fmu_refuse_time(f, "time", time)) return fmi2Error;
  if (time != f->now.t) {
    f->now.t = time;
    fmu_moved(f);
  }
  return fmi2OK;
}

FMI fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t count) {
  ALLOW(FMU_CONTINUOUS | FMU_EVENTS, fmi2SetContinuousStates);
  return fmu_done(fmu_set_states(f, x, count));
}

FMI fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real values[], size_t count) {
  int status;
  ALLOW(FMU_INITIALIZING | FMU_CONTINUOUS | FMU_EVENTS | FMU_TERMINATED, fmi2GetDerivatives);
  if (count != NX) return fmi2Error;
  status = fmu_evaluate(f);
  if (status == FMU_OK) memcpy(values, f->engine->ode, sizeof(double) * NX);
  return fmu_done(status);
}

FMI fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real values[], size_t count) {
  ALLOW(FMU_INITIALIZING | FMU_CONTINUOUS | FMU_EVENTS | FMU_TERMINATED, fmi2GetEventIndicators);
  return count == EVENTS ? fmu_done(EVENTS ? fmu_shown_indicators(f, values) : FMU_OK) : fmi2Error;
}

FMI fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t count) {
  int status = FMU_OK;
  ALLOW(FMU_INITIALIZING | FMU_CONTINUOUS | FMU_EVENTS | FMU_TERMINATED, fmi2GetContinuousStates);
  if (count != NX) return fmi2Error;
  if (f->now.phase == FMU_INITIALIZING) status = fmu_solve(f);
  memcpy(x, f->now.x, sizeof(double) * NX);
  return fmu_done(status);
}

FMI fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real values[], size_t count) {
  ALLOW(ALIVE, fmi2GetNominalsOfContinuousStates);
  if (count != NX) return fmi2Error;
  memcpy(values, fmu_x_nominal, sizeof(double) * NX);
  return fmi2OK;
}

/* --- co-simulation ------------------------------------------------------------------------------------------------- */

FMI fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference r[], size_t count,
                                           const fmi2Integer order[], const fmi2Real values[]) {
  ALLOW(ALIVE, fmi2SetRealInputDerivatives);
  (void)r, (void)order, (void)values;
  if (!count) return fmi2OK;
  fmu_tell(f, FMU_ERROR, "logStatusError", "inputs are held over a communication step; they have no derivatives.");
  return fmi2Error;
}

FMI fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference r[], size_t count,
                                            const fmi2Integer order[], fmi2Real values[]) {
  ALLOW(ALIVE, fmi2GetRealOutputDerivatives);
  (void)r, (void)order, (void)values;
  if (!count) return fmi2OK;
  fmu_tell(f, FMU_ERROR, "logStatusError", "outputs come without derivatives.");
  return fmi2Error;
}

FMI fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean no_return) {
  int status, stopped;
  ALLOW(FMU_STEPPING, fmi2DoStep);
  (void)no_return;
  status = fmu_check_step(f, t, h);
  if (status == FMU_OK) status = fmu_do_step(f, h, &stopped);
  if (status >= FMU_DISCARD) f->now.phase = FMU_FAILED;
  return fmu_done(status >= FMU_DISCARD ? FMU_ERROR : status);
}

FMI fmi2Status fmi2CancelStep(fmi2Component c) {
  ALLOW(ALIVE, fmi2CancelStep);
  fmu_tell(f, FMU_ERROR, "logStatusError", "there is no step to cancel: a step is finished when fmi2DoStep returns.");
  return fmi2Error;
}

FMI fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value) {
  ALLOW(ALIVE, fmi2GetStatus);
  (void)value;
  return kind == fmi2DoStepStatus ? fmi2Discard : fmi2Error;
}

FMI fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value) {
  ALLOW(ALIVE, fmi2GetRealStatus);
  if (kind != fmi2LastSuccessfulTime) return fmi2Error;
  *value = f->now.t;
  return fmi2OK;
}

FMI fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value) {
  (void)c, (void)kind, (void)value;
  return fmi2Discard;
}

FMI fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value) {
  ALLOW(ALIVE, fmi2GetBooleanStatus);
  if (kind != fmi2Terminated) return fmi2Error;
  *value = f->now.phase == FMU_FAILED;
  return fmi2OK;
}

FMI fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind kind, fmi2String *value) {
  (void)c, (void)kind, (void)value;
  return fmi2Discard;
}
