/* A small importer of co-simulation: loads the library of an FMU and prints variables after each communication step.

   Usage: host <library> <2 or 3> <token> <resources, %-encoded> <steps> <step> <value reference>... */

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef _WIN32
#include <windows.h>
static void *library(const char *path) { return (void *)LoadLibraryA(path); }
static void *function(void *from, const char *name) { return (void *)GetProcAddress((HMODULE)from, name); }
#else
#include <dlfcn.h>
static void *library(const char *path) { return dlopen(path, RTLD_NOW | RTLD_LOCAL); }
static void *function(void *from, const char *name) { return dlsym(from, name); }
#endif

static void hear2(void *environment, const char *name, int status, const char *category, const char *text, ...) {
  fprintf(stderr, "%d %s\n", status, text);
}
static void hear3(void *environment, int status, const char *category, const char *text) {
  fprintf(stderr, "%d %s\n", status, text);
}

int main(int count, char **argument) {
  enum { MOST = 100 };
  struct { void (*logger)(void *, const char *, int, const char *, const char *, ...); void *rest[4]; } callbacks = {hear2};
  char folder[4096], *to = folder, *from;
  unsigned reference[MOST];
  double value[MOST], step = atof(argument[6]), last;
  int version = atoi(argument[2]), steps = atoi(argument[5]), n = count - 7, k, i, bad = 0;
  void *fmu = library(argument[1]), *c;
  bool event, terminate, early;
  for (from = argument[4]; *from; from++) {
    unsigned code;
    if (version == 3 && *from == '%' && sscanf(from + 1, "%2x", &code) == 1) *to++ = (char)code, from += 2;
    else *to++ = *from;
  }
  *to = 0;
  for (i = 0; i < n && i < MOST; i++) reference[i] = (unsigned)atoi(argument[7 + i]);
  if (!fmu) return fprintf(stderr, "the library %s cannot be loaded\n", argument[1]), 2;
#define GET(result, name, ...) \
  result (*name)(__VA_ARGS__) = (result (*)(__VA_ARGS__))function(fmu, #name); \
  if (!name) return fprintf(stderr, "no %s\n", #name), 3
  if (version == 2) {
    GET(void *, fmi2Instantiate, const char *, int, const char *, const char *, void *, int, int);
    GET(int, fmi2SetupExperiment, void *, int, double, double, int, double);
    GET(int, fmi2EnterInitializationMode, void *);
    GET(int, fmi2ExitInitializationMode, void *);
    GET(int, fmi2DoStep, void *, double, double, int);
    GET(int, fmi2GetReal, void *, const unsigned *, size_t, double *);
    GET(void, fmi2FreeInstance, void *);
    c = fmi2Instantiate("host", 1, argument[3], folder, &callbacks, 0, 0);
    if (!c) return 4;
    bad = fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0) || fmi2EnterInitializationMode(c) || fmi2ExitInitializationMode(c);
    for (k = 0; k < steps && !bad; k++) {
      bad = fmi2DoStep(c, k * step, step, 1) || fmi2GetReal(c, reference, (size_t)n, value);
      for (i = 0; i < n; i++) printf("%.17g ", value[i]);
      printf("\n");
    }
    fmi2FreeInstance(c);
  } else {
    GET(void *, fmi3InstantiateCoSimulation, const char *, const char *, const char *, bool, bool, bool, bool,
        const unsigned *, size_t, void *, void (*)(void *, int, const char *, const char *), void *);
    GET(int, fmi3EnterInitializationMode, void *, bool, double, double, bool, double);
    GET(int, fmi3ExitInitializationMode, void *);
    GET(int, fmi3DoStep, void *, double, double, bool, bool *, bool *, bool *, double *);
    GET(int, fmi3GetFloat64, void *, const unsigned *, size_t, double *, size_t);
    GET(void, fmi3FreeInstance, void *);
    c = fmi3InstantiateCoSimulation("host", argument[3], folder, false, false, false, false, 0, 0, 0, hear3, 0);
    if (!c) return 4;
    bad = fmi3EnterInitializationMode(c, false, 0.0, 0.0, false, 0.0) || fmi3ExitInitializationMode(c);
    for (k = 0; k < steps && !bad; k++) {
      bad = fmi3DoStep(c, k * step, step, false, &event, &terminate, &early, &last)
          || fmi3GetFloat64(c, reference, (size_t)n, value, (size_t)n);
      for (i = 0; i < n; i++) printf("%.17g ", value[i]);
      printf("\n");
    }
    fmi3FreeInstance(c);
  }
  return bad ? 5 : 0;
}
