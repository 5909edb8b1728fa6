/* Series of time by a number, their handle: values and time derivatives in C11, see casadi_interface.c.

   One library, made for NAME, say series_3, and OUTPUTS values, serves any number of series. A series is made
   known by series_3_load(handle, numbers, count) from memory or series_3_open(handle, path) from a file with the same
   numbers packed, and forgotten by series_3_close(handle), as often as it was made known. The numbers: those of `Head`, then
   what the kind needs. Then series_3 and jac_series_3 can be called.

   Input: handle, time [s]. Output: the values. The handle 0 stands for zeros. Outside of its range a series keeps the
   value of its edge; the caller checks the range. Making known and forgetting is not for several threads at a time;
   calls are. An unknown handle makes a call return 1, and series_3_problem() says why, once. */

#include <errno.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#ifdef _WIN32
#define WIN32_LEAN_AND_MEAN
#include <windows.h>
#endif

enum { SIGNALS = OUTPUTS };
enum { CONSTANT, CUBIC, LINEAR, MONOTONE, HARMONICS, TRANSITION };

/* start, step: of samples [s], or start and duration of a transition; count: rows of samples or coefficients, or
   harmonics; order: rows of the polynomial of a transition; build_up: time in which the series grows from nothing [s]. */
typedef struct {
    double magic, kind, size, periodic, start, step, count, order, build_up;
} Head;

static const double MAGIC = 0x1.fee1badp+40;

typedef struct {
    double handle;
    int uses;
    Head head;
    double *rows;
} Series;

static Series *table; /* by hashed handle; a place whose handle is 0 is free */
static size_t places, known;
static char problem[1200];

static int refuse(const char *path, const char *what, const char *more) {
    snprintf(problem, sizeof problem, "%.1000s%sthe time series %s%s", path, path[0] ? ": " : "", what, more);
    return 1;
}

/* --- which series there are --------------------------------------------------------------------------------------- */

static size_t place_of(double handle) {
    uint64_t bits;
    memcpy(&bits, &handle, sizeof bits);
    bits ^= bits >> 29;
    return (size_t)((bits * 0x9e3779b97f4a7c15ULL) >> 20) & (places - 1);
}

static Series *find(double handle) {
    if (!places) return NULL;
    size_t i = place_of(handle);
    while (table[i].handle != 0 && table[i].handle != handle) i = (i + 1) & (places - 1);
    return table[i].handle != 0 ? &table[i] : NULL;
}

static int grow(void) {
    Series *old = table, *fresh = calloc(places ? 2 * places : 64, sizeof *fresh);
    const size_t before = places;
    if (!fresh) return 1;
    table = fresh, places = places ? 2 * places : 64;
    for (size_t k = 0; k < before; k++) {
        if (old[k].handle == 0) continue;
        size_t i = place_of(old[k].handle);
        while (table[i].handle != 0) i = (i + 1) & (places - 1);
        table[i] = old[k];
    }
    free(old);
    return 0;
}

/* Numbers behind the head. */
static double needed(const Head *h) {
    const double rows[] = {1, h->count, h->count, 2 * h->count, 0, 2 + h->order};
    const int kind = (int)h->kind;
    return rows[kind] * SIGNALS + (kind == HARMONICS || kind == TRANSITION ? h->count * (1 + 2.0 * SIGNALS) : 0);
}

static int add(double handle, const double *numbers, double count, const char *path) {
    Series *there = find(handle);
    if (there) {
        there->uses++;
        return 0;
    }
    Head h;
    const double head = sizeof h / sizeof(double);
    if (count < head) return refuse(path, "is damaged", "");
    memcpy(&h, numbers, sizeof h);
    if (h.magic != MAGIC || h.size != SIGNALS || !(h.kind >= CONSTANT && h.kind <= TRANSITION) || count != head + needed(&h))
        return refuse(path, "is damaged, or of another machine", "");
    if (2 * (known + 1) > places && grow()) return refuse(path, "finds no memory", "");
    double *rows = malloc((size_t)(count - head + 1) * sizeof *rows);
    if (!rows) return refuse(path, "finds no memory", "");
    memcpy(rows, numbers + (size_t)head, (size_t)(count - head) * sizeof *rows);
    size_t i = place_of(handle);
    while (table[i].handle != 0) i = (i + 1) & (places - 1);
    table[i] = (Series){handle, 1, h, rows};
    known++;
    return 0;
}

EXPORT int FUNCTION(_load)(double handle, const double *numbers, long long count) {
    return add(handle, numbers, (double)count, "");
}

static FILE *open_file(const char *path) {
#ifdef _WIN32
    wchar_t wide[1024];
    return MultiByteToWideChar(CP_UTF8, 0, path, -1, wide, 1024) ? _wfopen(wide, L"rb") : NULL;
#else
    return fopen(path, "rb");
#endif
}

enum { DIFFERENCES = 6 };

/* The numbers of a file behind its head: a scale for each column, then the bytes of the sixth differences along each
   column of whole numbers of 64 bits, first all lowest bytes. With a scale above zero the whole numbers count it, else
   they are the bits of the numbers. So they compress well, and come back to the last bit. */
static void unpack(const double *scales, long long rows, int columns, double *numbers) {
    const unsigned char *bytes = (const unsigned char *)(scales + columns);
    const long long count = rows * columns;
    for (int c = 0; c < columns; c++) {
        uint64_t sums[DIFFERENCES] = {0};
        for (long long i = 0; i < rows; i++) {
            uint64_t change = 0;
            for (int k = 0; k < 8; k++) change |= (uint64_t)bytes[k * count + c * rows + i] << 8 * k;
            for (int k = 0; k < DIFFERENCES; k++) change = sums[k] += change;
            double number;
            memcpy(&number, &change, sizeof number);
            numbers[i * columns + c] = scales[c] > 0 ? (double)(int64_t)change * scales[c] : number;
        }
    }
}

EXPORT int FUNCTION(_open)(double handle, const char *path) {
    FILE *file = open_file(path);
    if (!file) return refuse(path, "cannot be read: ", strerror(errno));
    const long long head = sizeof(Head) / sizeof(double);
    long length = fseek(file, 0, SEEK_END) ? -1 : ftell(file);
    double *packed = length > 0 && !fseek(file, 0, SEEK_SET) ? malloc((size_t)length) : NULL;
    int bad = !packed || fread(packed, 1, (size_t)length, file) < (size_t)length;
    fclose(file);
    if (bad) {
        bad = refuse(path, "cannot be read", "");
    } else {
        const int columns = length / 8 > head && packed[1] < HARMONICS ? SIGNALS : 1;
        const long long count = length / 8 - head - columns;
        double *numbers = count >= 0 ? malloc((size_t)(head + count + 1) * sizeof *numbers) : NULL;
        if (numbers) {
            memcpy(numbers, packed, sizeof(Head));
            if (count % columns == 0) unpack(packed + head, count / columns, columns, numbers + head);
            bad = count % columns ? refuse(path, "is damaged", "") : add(handle, numbers, (double)(head + count), path);
        } else {
            bad = refuse(path, count < 0 ? "is damaged" : "finds no memory", "");
        }
        free(numbers);
    }
    free(packed);
    return bad;
}

EXPORT void FUNCTION(_close)(double handle) {
    Series *s = find(handle);
    if (!s || --s->uses) return;
    free(s->rows);
    s->handle = 0;
    known--;
    for (size_t i = (size_t)(s - table + 1) & (places - 1); table[i].handle != 0; i = (i + 1) & (places - 1)) {
        const Series moved = table[i]; /* those behind it may have been put there because its place was taken */
        table[i].handle = 0;
        size_t j = place_of(moved.handle);
        while (table[j].handle != 0) j = (j + 1) & (places - 1);
        table[j] = moved;
    }
}

/* The reason for which the last call returned 1, as UTF-8; empty when there is none, or when it was asked before. */
EXPORT const char *FUNCTION(_problem)(void) {
    static char told[sizeof problem];
    memcpy(told, problem, sizeof told);
    problem[0] = 0;
    return told;
}

/* --- values ------------------------------------------------------------------------------------------------------- */

/* out += weight * row, and the same of the derivative. */
static void add_row(const double *row, double weight, double slope, double *out, double *rate) {
    for (int j = 0; j < SIGNALS; j++) out[j] += weight * row[j];
    for (int j = 0; rate && j < SIGNALS; j++) rate[j] += slope * row[j];
}

/* A row of cosine and a row of sine parts behind an angular frequency, at the argument s with ds/dt = per. */
static void add_harmonic(const double *numbers, double s, double per, double *out, double *rate) {
    const double w = numbers[0], c = cos(w * s), d = sin(w * s);
    add_row(numbers + 1, c, -w * per * d, out, rate);
    add_row(numbers + 1 + SIGNALS, -d, -w * per * c, out, rate);
}

static void samples(const Head *h, const double *rows, double t, double *out, double *rate) {
    const int kind = (int)h->kind, wraps = h->periodic != 0;
    const double count = kind == CUBIC ? h->count - (wraps ? 3 : 2) : h->count, cells = wraps ? count : count - 1;
    double place = (t - h->start) / h->step, per = 1 / h->step;
    if (wraps) {
        place -= cells * floor(place / cells);
    } else if (!(place >= 0 && place <= cells)) {
        place = place < 0 ? 0 : cells;
        per = 0;
    }
    const size_t low = (size_t)(place < cells ? floor(place) : cells - 1), next = wraps && low + 1 >= cells ? 0 : low + 1;
    const double s = place - (double)low, r = 1 - s;
    if (kind == CUBIC) {
        const double w[4] = {r * r * r / 6, (s * s * (3 * s - 6) + 4) / 6, (r * r * (3 * r - 6) + 4) / 6, s * s * s / 6};
        const double d[4] = {-r * r / 2, s * (1.5 * s - 2), r * (2 - 1.5 * r), s * s / 2};
        for (int i = 0; i < 4; i++) add_row(rows + (low + (size_t)i) * SIGNALS, w[i], d[i] * per, out, rate);
    } else if (kind == LINEAR) {
        add_row(rows + low * SIGNALS, r, -per, out, rate);
        add_row(rows + next * SIGNALS, s, per, out, rate);
    } else { /* a value and a slope per sample: Hermite's polynomials */
        const double *a = rows + 2 * low * SIGNALS, *b = rows + 2 * next * SIGNALS, bend = 6 * s * r * per;
        add_row(a, r * r * (1 + 2 * s), -bend, out, rate);
        add_row(b, s * s * (3 - 2 * s), bend, out, rate);
        add_row(a + SIGNALS, h->step * s * r * r, r * (1 - 3 * s) * per * h->step, out, rate);
        add_row(b + SIGNALS, -h->step * s * s * r, s * (3 * s - 2) * per * h->step, out, rate);
    }
}

/* Rows before and after; between them a polynomial in s from 0 to 1, constant first, and harmonics in s. */
static void transition(const Head *h, const double *rows, double t, double *out, double *rate) {
    const double s = (t - h->start) / h->step, per = 1 / h->step;
    if (!(s > 0 && s < 1)) {
        add_row(s <= 0 ? rows : rows + SIGNALS, 1, 0, out, rate);
        return;
    }
    double power = 1, slope = 0;
    rows += 2 * SIGNALS;
    for (int i = 0; i < (int)h->order; i++, rows += SIGNALS) {
        add_row(rows, power, slope, out, rate);
        slope = (i + 1) * power * per;
        power *= s;
    }
    for (int k = 0; k < (int)h->count; k++, rows += 1 + 2 * SIGNALS) add_harmonic(rows, s, per, out, rate);
}

/* Values, and where `rate` is given their time derivatives; returns 1 with a problem. */
static int evaluate(double handle, double t, double *out, double *rate) {
    memset(out, 0, SIGNALS * sizeof *out);
    if (rate) memset(rate, 0, SIGNALS * sizeof *rate);
    if (handle == 0) return 0;
    const Series *s = find(handle);
    if (!s) return refuse("", "was not opened in this process; compile the model again", "");
    const Head *h = &s->head;
    const double *rows = s->rows;
    if (!isfinite(t)) {
        for (int j = 0; j < SIGNALS; j++) out[j] = NAN;
        for (int j = 0; rate && j < SIGNALS; j++) rate[j] = NAN;
        return 0;
    }
    if (h->kind == CONSTANT)
        memcpy(out, rows, SIGNALS * sizeof *out);
    else if (h->kind == HARMONICS)
        for (int k = 0; k < (int)h->count; k++) add_harmonic(rows + k * (1 + 2 * SIGNALS), t, 1, out, rate);
    else if (h->kind == TRANSITION)
        transition(h, rows, t, out, rate);
    else
        samples(h, rows, t, out, rate);
    if (h->build_up > 0 && t < h->build_up) { /* 10 s^3 - 15 s^4 + 6 s^5 */
        const double p = t > 0 ? t / h->build_up : 0, share = p * p * p * (10 + p * (6 * p - 15));
        const double growth = 30 * p * p * (1 - p) * (1 - p) / h->build_up;
        for (int j = 0; rate && j < SIGNALS; j++) rate[j] = share * rate[j] + growth * out[j];
        for (int j = 0; j < SIGNALS; j++) out[j] *= share;
    }
    return 0;
}

EXPORT int FUNCTION()(const double **arg, double **res, casadi_int *iw, double *w, int mem) {
    (void)iw, (void)w, (void)mem;
    return !res[0] ? 0 : !arg[0] ? 1 : evaluate(arg[0][0], arg[0][1], res[0], NULL);
}

EXPORT int JACOBIAN()(const double **arg, double **res, casadi_int *iw, double *w, int mem) {
    double values[SIGNALS];
    (void)iw, (void)w, (void)mem;
    return !res[0] ? 0 : !arg[0] ? 1 : evaluate(arg[0][0], arg[0][1], values, res[0]);
}
