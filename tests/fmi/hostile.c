/* A hostile importer: calls of an FMU in a random order with odd values, compiled together with its sources.

   Usage: hostile <folder of the resources> <seed> <rounds>. Each round makes an instance and calls it at random; after a
   reset it must repeat the reference trajectory bit for bit. Meant for AddressSanitizer and UndefinedBehaviorSanitizer.
   Compile with -DINTERFACE=2 or 3 and the sources on the include path. */

#include "fmu.c"
#include <stdio.h>

enum { SLOTS = 3, POINTS = 12, MANY = 8 };

static unsigned long long seed;
static unsigned pick(unsigned n) {
  seed = seed * 6364136223846793005ull + 1442695040888963407ull;
  return (unsigned)(seed >> 33) % n;
}

static double odd(void) {
  static const double values[] = {0.0, -0.0, 1.0, -1.0, 0.05, 0.01, 0.3, 4.25, 1e-12, 5e-324, 1e17, -1e17, 1e300, -1e300};
  unsigned i = pick(sizeof values / sizeof *values + 4);
  if (i < sizeof values / sizeof *values) return values[i];
  return i % 4 == 0 ? NAN : i % 4 == 1 ? INFINITY : i % 4 == 2 ? -INFINITY : (double)pick(1000) * 1e-3 - 0.5;
}

static unsigned reference(void) {
  static const unsigned values[] = {FIRST_SOLVER + 3, 10000, 0x7fffffff, 0x80000000u, 0xffffffffu};
  return pick(8) ? pick(FIRST_SOLVER + 4) : values[pick(5)];
}

static long heard;

#if INTERFACE == 3
#define F(name) fmi3##name
typedef fmi3Status status;
typedef fmi3FMUState saved_state;
typedef fmi3Byte byte;
typedef fmi3Instance instance;
static void hear(void *environment, fmi3Status s, const char *category, const char *text) {
  (void)environment, (void)s;
  heard += (long)(strlen(category) + strlen(text));
}
static void intermediate(void *environment, double t, bool may_set, bool may_get, bool finished, bool may_return,
                         bool *asked, double *when);
static instance make(const char *folder, int cs, int early) {
  if (!cs) return fmi3InstantiateModelExchange("one", MODEL_TOKEN, folder, false, pick(2), 0, hear);
  return fmi3InstantiateCoSimulation("one", MODEL_TOKEN, folder, false, pick(2), false, early, 0, 0, 0, hear,
                                     early ? intermediate : 0);
}
static status get(instance c, const unsigned *r, size_t n, double *v) { return fmi3GetFloat64(c, r, n, v, n); }
static status set(instance c, const unsigned *r, size_t n, const double *v) { return fmi3SetFloat64(c, r, n, v, n); }
static status enter(instance c, double t) { return fmi3EnterInitializationMode(c, pick(2), odd(), t, pick(2), odd()); }
static status step(instance c, double t, double h) {
  bool event, terminate, early;
  double last;
  return fmi3DoStep(c, t, h, pick(2), &event, &terminate, &early, &last);
}
static status update(instance c) {
  bool again, terminate, nominals, values, defined;
  double time;
  return fmi3UpdateDiscreteStates(c, &again, &terminate, &nominals, &values, &defined, &time);
}
static status completed(instance c) {
  bool event, terminate;
  return fmi3CompletedIntegratorStep(c, pick(2), &event, &terminate);
}
static status derivatives(instance c, double *v, size_t n) { return fmi3GetContinuousStateDerivatives(c, v, n); }
static status direction(instance c, const unsigned *u, size_t n, const unsigned *k, size_t m, const double *s, double *v) {
  return fmi3GetDirectionalDerivative(c, u, n, k, m, s, m, v, n);
}
static status restore(instance c, const byte *bytes, size_t n, saved_state *s) { return fmi3DeserializeFMUState(c, bytes, n, s); }
static status other(instance c) {
  unsigned r = reference();
  int32_t i = 0, order = 1;
  bool b = false;
  const char *text = "";
  size_t n = 0;
  double v = 0.0;
  fmi3DependencyKind kind;
  switch (pick(11)) {
    case 0: return fmi3GetInt32(c, &r, 1, &i, 1);
    case 1: return fmi3SetBoolean(c, &r, 1, &b, 1);
    case 2: return fmi3GetString(c, &r, 1, &text, 1);
    case 3: return fmi3GetClock(c, &r, 1, &b);
    case 4: return fmi3GetOutputDerivatives(c, &r, 1, &order, &v, 1);
    case 5: return fmi3GetNumberOfVariableDependencies(c, r, &n);
    case 6: return fmi3GetVariableDependencies(c, r, &n, &r, &n, &kind, 1);
    case 7: return fmi3GetAdjointDerivative(c, &r, 1, &r, 1, &v, 1, &v, 1);
    case 8: return fmi3EnterConfigurationMode(c);
    case 9: return fmi3EnterStepMode(c);
    default: return fmi3EvaluateDiscreteStates(c);
  }
}
#else
#define F(name) fmi2##name
#define fmi2GetFMUState fmi2GetFMUstate
#define fmi2SetFMUState fmi2SetFMUstate
#define fmi2FreeFMUState fmi2FreeFMUstate
#define fmi2SerializeFMUState fmi2SerializeFMUstate
#define fmi2SerializedFMUStateSize fmi2SerializedFMUstateSize
typedef fmi2Status status;
typedef fmi2FMUstate saved_state;
typedef fmi2Byte byte;
typedef fmi2Component instance;
static void hear(void *environment, const char *name, fmi2Status s, const char *category, const char *text, ...) {
  (void)environment, (void)name, (void)s;
  heard += (long)(strlen(category) + strlen(text));
}
static instance make(const char *folder, int cs, int early) {
  fmi2CallbackFunctions functions = {hear, calloc, free, 0, 0}; /* it need not live longer than this call */
  char location[4096];
  (void)early;
  snprintf(location, sizeof location, "file://%s", folder);
  return fmi2Instantiate("one", cs ? fmi2CoSimulation : fmi2ModelExchange, MODEL_TOKEN, location, &functions, 0,
                         (int)pick(2));
}
static status get(instance c, const unsigned *r, size_t n, double *v) { return fmi2GetReal(c, r, n, v); }
static status set(instance c, const unsigned *r, size_t n, const double *v) { return fmi2SetReal(c, r, n, v); }
static status enter(instance c, double t) {
  fmi2SetupExperiment(c, (int)pick(2), odd(), t, (int)pick(2), odd());
  return fmi2EnterInitializationMode(c);
}
static status step(instance c, double t, double h) { return fmi2DoStep(c, t, h, (int)pick(2)); }
static status update(instance c) {
  fmi2EventInfo info;
  return fmi2NewDiscreteStates(c, &info);
}
static status completed(instance c) {
  int event, terminate;
  return fmi2CompletedIntegratorStep(c, (int)pick(2), &event, &terminate);
}
static status derivatives(instance c, double *v, size_t n) { return fmi2GetDerivatives(c, v, n); }
static status direction(instance c, const unsigned *u, size_t n, const unsigned *k, size_t m, const double *s, double *v) {
  return fmi2GetDirectionalDerivative(c, u, n, k, m, s, v);
}
static status restore(instance c, const byte *bytes, size_t n, saved_state *s) { return fmi2DeSerializeFMUstate(c, bytes, n, s); }
static status other(instance c) {
  unsigned r = reference();
  int i = 0;
  double v = 0.0;
  fmi2String text = "";
  fmi2Status s;
  switch (pick(9)) {
    case 0: return fmi2GetInteger(c, &r, 1, &i);
    case 1: return fmi2SetBoolean(c, &r, 1, &i);
    case 2: return fmi2GetString(c, &r, 1, &text);
    case 3: return fmi2SetRealInputDerivatives(c, &r, 1, &i, &v);
    case 4: return fmi2GetRealOutputDerivatives(c, &r, 1, &i, &v);
    case 5: return fmi2CancelStep(c);
    case 6: return fmi2GetStatus(c, fmi2DoStepStatus, &s);
    case 7: return fmi2GetRealStatus(c, fmi2LastSuccessfulTime, &v);
    default: return fmi2GetBooleanStatus(c, fmi2Terminated, &i);
  }
}
#endif

static void wild(instance c, saved_state *slots, int calls);

#if INTERFACE == 3
static instance now_stepping;
static int depth;
static void intermediate(void *environment, double t, bool may_set, bool may_get, bool finished, bool may_return,
                         bool *asked, double *when) {
  (void)environment, (void)may_set, (void)may_get, (void)finished, (void)may_return;
  if (depth++ == 0) wild(now_stepping, 0, 3);
  depth--;
  *asked = !pick(4);
  *when = t;
}
#endif

/* Time of the instance, as it says itself. */
static double time_of(instance c) {
  unsigned r = 0;
  double t = 0.0;
  get(c, &r, 1, &t);
  return t;
}

/* A saved state through its bytes: whole, cut, or spoilt. */
static void through_bytes(instance c, saved_state *slot) {
  size_t size = 0, given, i;
  byte *bytes;
  saved_state again = 0;
  if (!*slot || F(SerializedFMUStateSize)(c, *slot, &size)) return;
  given = pick(3) ? size : pick((unsigned)size);
  bytes = malloc(given ? given : 1);
  if (F(SerializeFMUState)(c, *slot, bytes, given) == 0) {
    for (i = 0; i < 3 && pick(2); i++) bytes[pick((unsigned)given)] ^= (byte)(1u << pick(8));
    if (restore(c, bytes, pick(3) ? given : pick((unsigned)given), &again) == 0) F(SetFMUState)(c, again);
    F(FreeFMUState)(c, &again);
  } else if (restore(c, bytes, 0, &again) == 0) F(FreeFMUState)(c, &again);
  free(bytes);
}

static void wild(instance c, saved_state *slots, int calls) {
  double values[MANY], seeds[MANY], *states = malloc(sizeof(double) * AT_LEAST(NX)), *shown = malloc(sizeof(double) * AT_LEAST(EVENTS));
  unsigned references[MANY], others[MANY];
  int i;
  while (calls-- > 0) {
    unsigned n = pick(MANY), k = pick(SLOTS);
    for (i = 0; i < MANY; i++) {
      references[i] = reference();
      others[i] = pick(2) ? FIRST_RATE + pick(AT_LEAST(NX)) : reference();
      values[i] = odd();
      seeds[i] = odd();
    }
    for (i = 0; i < NX; i++) states[i] = pick(3) ? odd() : fmu_states[i].start;
    switch (pick(26)) {
      case 0: enter(c, pick(3) ? 0.0 : odd()); break;
      case 1: F(ExitInitializationMode)(c); break;
      case 2: case 3: get(c, references, n, values); break;
      case 4: case 5: set(c, references, pick(3) ? n > 0 : n, values); break;
      case 6: case 7: case 8: step(c, pick(4) ? time_of(c) : odd(), pick(2) ? 0.05 : odd()); break;
      case 9: if (!pick(4)) F(Terminate)(c); break;
      case 10: if (!pick(3)) F(Reset)(c); break;
      case 11: if (slots) F(GetFMUState)(c, slots + k); break;
      case 12: if (slots) F(SetFMUState)(c, slots[k]); break;
      case 13: if (slots) F(FreeFMUState)(c, slots + k); break;
      case 14: if (slots) through_bytes(c, slots + k); break;
      case 15: F(EnterEventMode)(c); break;
      case 16: update(c); break;
      case 17: F(EnterContinuousTimeMode)(c); break;
      case 18: completed(c); break;
      case 19: F(SetTime)(c, pick(2) ? 0.1 * pick(10) : odd()); break;
      case 20: F(SetContinuousStates)(c, states, pick(5) ? NX : pick(3)); break;
      case 21: derivatives(c, states, pick(5) ? NX : 0); break;
      case 22: F(GetEventIndicators)(c, shown, pick(5) ? EVENTS : 0); break;
      case 23: F(GetContinuousStates)(c, states, NX); F(GetNominalsOfContinuousStates)(c, states, NX); break;
      case 24: direction(c, others, n, references, pick(MANY), seeds, values); break;
      default: other(c);
    }
  }
  free(states);
  free(shown);
}

/* The instance from its start through some steps of co-simulation; 1 where a call does not succeed. */
static int trajectory(instance c, double *rows) {
  unsigned r[3] = {FIRST_STATE + NX - 1, FIRST_RATE, FIRST_OUTPUT > FIRST_STATE ? FIRST_STATE : 0};
  int k;
  if (enter(c, 0.0) || F(ExitInitializationMode)(c)) return 1;
  for (k = 0; k < POINTS; k++)
    if (step(c, 0.05 * k, 0.05) || get(c, r, 3, rows + 3 * k)) return 1;
  return 0;
}

int main(int count, char **argument) {
  static double reference_rows[3 * POINTS], rows[3 * POINTS];
  int round, k, rounds = count > 3 ? atoi(argument[3]) : 1;
  instance c = make(argument[1], 1, 0);
  seed = count > 2 ? strtoull(argument[2], 0, 10) : 1;
  if (!c || trajectory(c, reference_rows)) return puts("no reference"), 2;
  F(FreeInstance)(c);
  c = make("/no/such/folder", 1, 0);
  if (c && STORED) return puts("tables from nowhere"), 2;
  F(FreeInstance)(c);
  wild(0, 0, 50);
  for (round = 0; round < rounds; round++) {
    saved_state slots[SLOTS] = {0};
    int cs = (int)pick(3) > 0;
    c = make(argument[1], cs, (int)pick(2));
    if (!c) return puts("no instance"), 2;
#if INTERFACE == 3
    now_stepping = c;
#endif
    if (pick(2)) {
      enter(c, 0.0);
      F(ExitInitializationMode)(c);
      if (!cs) F(EnterContinuousTimeMode)(c);
    }
    wild(c, slots, 40);
    if (cs) {
#if INTERFACE == 3
      ((fmu_instance3 *)c)->core.intermediate = 0;
#endif
      if (F(Reset)(c) || trajectory(c, rows) || memcmp(rows, reference_rows, sizeof rows)) {
        printf("round %d: another trajectory after a reset\n", round);
        return 1;
      }
    }
    for (k = 0; k < SLOTS; k++) F(FreeFMUState)(c, slots + k);
    F(FreeInstance)(c);
  }
  printf("%ld characters heard\n", heard);
  return 0;
}
