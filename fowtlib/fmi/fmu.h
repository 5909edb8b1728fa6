/* What the generated tables of a model, fmu_core.c and the interfaces fmi2.c and fmi3.c share.

   The order of the texts in one translation unit: spline.c, fixed_step.c, fmu.h, tables.h (generated), fmu_core.c, and
   fmi2.c or fmi3.c. The generated functions of the model (model.c) and the code of its external functions are compiled
   on their own. All variables are of type double; their value references are numbered by groups in the order of enum
   fmu_group, which tables.h gives the first numbers of. */

#include <stdarg.h>
#include <stdio.h>

/* Directional derivative of a function of the model: seeds of x, z, q and w. */
typedef void (*fmu_forward_code)(const double *t, const double *x, const double *z, const double *q, const double *w,
                                 const double *dx, const double *dz, const double *dq, const double *dw, double *first,
                                 double *second, double *scratch);

typedef struct { const char *path, *unit, *doc; double start, low, high; } fmu_quantity; /* low, high: infinite if none */
typedef struct { const char *function, *path; } fmu_external_name;
typedef struct { long long first, count; int columns; } fmu_stored; /* a table of resources/tables.bin */
typedef struct { int spline, part, table; } fmu_table_use; /* part: 0, 1 knots, 2 coefficients */
typedef struct { const char *path; int states, discretes; const int *state, *discrete; fs_code action; } fmu_event;
typedef struct { const char *path; int targets, needs_outputs; const int *target; fs_code update; } fmu_sample;
typedef struct { const char *path, *message; int is_error, values; const char *const *names; } fmu_check;
typedef struct { const char *file; int (*open)(const char *path); const char *(*problem)(void); } fmu_file;

/* Severity of a message, and the outcome of a call. */
enum { FMU_OK, FMU_WARNING, FMU_DISCARD, FMU_ERROR };

/* What may be called: bits of fmu_instance.phase. */
enum { FMU_INSTANTIATED = 1, FMU_INITIALIZING = 2, FMU_EVENTS = 4, FMU_CONTINUOUS = 8, FMU_STEPPING = 16,
       FMU_INTERMEDIATE = 32, FMU_TERMINATED = 64, FMU_FAILED = 128 };
enum { FMU_RUNNING = FMU_EVENTS | FMU_CONTINUOUS | FMU_STEPPING | FMU_INTERMEDIATE, ALIVE = 255,
       AT_REST = ALIVE & ~FMU_INTERMEDIATE, /* not within a communication step */
       SETTABLE = FMU_INSTANTIATED | FMU_INITIALIZING | (FMU_RUNNING & AT_REST) };
