/* The nodes of a rotor in vectors as wide as the processor has them, found out at the first call; and what CasADi calls. */

#if defined(ONLY_LANES) && ONLY_LANES == 1
#undef VECTORS
#endif

#ifdef VECTORS
typedef int nodes_at_once(int i, const double *u, const struct wake *wake, double *f, double *jac);

#define NAMED_(name, lanes) name##_##lanes
#define NAMED(name, lanes) NAMED_(name, lanes)

static int lanes; /* as many at most; 0 before the first call */

static int lanes_in_use(void) {
    if (!lanes) lanes = widest();
    int n = lanes;
    while (n > NODES) n /= 2;
#ifdef ONLY_LANES
    if (n != ONLY_LANES) n = 1; /* others are not compiled */
#endif
    return n;
}

/* For tests: no more lanes than these, one for none but `node`; returns how many are in use. */
EXPORT int FUNCTION(_lanes)(int most) {
    int n = widest();
    while (n > most && n > 1) n /= 2;
    lanes = n;
    return lanes_in_use();
}
#endif

static void rotor(const double *u, double *f, double *jac) {
    struct wake wake = {0};
    double wind[3];
    int first = 0;
    for (int k = 0; k < 3; k++) wind[k] = u[DISK_WIND + k] - u[HUB_VELOCITY + k];
    if (SKEWED_WAKE) skewed_wake(wind, u + HUB_ORIENTATION, &wake);
#ifdef VECTORS
    int n = lanes_in_use();
    if (n > 1) {
#ifdef ONLY_LANES
        nodes_at_once *nodes = NAMED(nodes, ONLY_LANES);
#elif defined(__x86_64__)
        nodes_at_once *nodes = n == 8 ? nodes_8 : n == 4 ? nodes_4 : nodes_2;
#else
        nodes_at_once *nodes = nodes_2;
#endif
        for (; first < NODES; first += n) {
            int i = first + n <= NODES ? first : NODES - n; /* the last ones take some of those before along */
            for (int left = nodes(i, u, &wake, f, jac); left; left &= left - 1) node(i + __builtin_ctz(left), u, &wake, f, jac);
        }
    }
#endif
    for (int i = first; i < NODES; i++) node(i, u, &wake, f, jac);
}

/* loads, and their Jacobian */
EXPORT int FUNCTION()(const double **arg, double **res, casadi_int *iw, double *w, int mem) {
    (void)iw, (void)w, (void)mem;
    if (!arg[0]) return 1;
    if (res[0]) rotor(arg[0], res[0], NULL);
    return 0;
}

EXPORT int JACOBIAN()(const double **arg, double **res, casadi_int *iw, double *w, int mem) {
    (void)iw, (void)w, (void)mem;
    if (!arg[0]) return 1;
    if (res[0]) rotor(arg[0], NULL, res[0]);
    return 0;
}
