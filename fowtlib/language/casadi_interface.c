/* CasADi's C interface of a function of one column and of its Jacobian: see "Using externally-defined functions" in its
   manual. `with_interface` of externals.py puts it in front of C text that defines FUNCTION() and JACOBIAN(), and writes
   before it NAME, INPUTS, OUTPUTS and `pattern`, that of the Jacobian by columns: sizes, starts of columns, rows. */

#define JOIN_(a, b) a##b
#define JOIN(a, b) JOIN_(a, b)
#define FUNCTION(suffix) JOIN(NAME, suffix)
#define JACOBIAN(suffix) JOIN(JOIN(jac_, NAME), suffix)

static const casadi_int column_of_inputs[] = {INPUTS, 1, 1}, column_of_outputs[] = {OUTPUTS, 1, 1};

static int work(casadi_int arguments, casadi_int *sz_arg, casadi_int *sz_res, casadi_int *sz_iw, casadi_int *sz_w) {
    if (sz_arg) *sz_arg = arguments;
    if (sz_res) *sz_res = 1;
    if (sz_iw) *sz_iw = 0;
    if (sz_w) *sz_w = 0;
    return 0;
}

EXPORT casadi_int FUNCTION(_n_in)(void) { return 1; }
EXPORT casadi_int FUNCTION(_n_out)(void) { return 1; }
EXPORT const casadi_int *FUNCTION(_sparsity_in)(casadi_int i) { (void)i; return column_of_inputs; }
EXPORT const casadi_int *FUNCTION(_sparsity_out)(casadi_int i) { (void)i; return column_of_outputs; }
EXPORT int FUNCTION(_work)(casadi_int *a, casadi_int *r, casadi_int *i, casadi_int *w) { return work(1, a, r, i, w); }

EXPORT casadi_int JACOBIAN(_n_in)(void) { return 2; }
EXPORT casadi_int JACOBIAN(_n_out)(void) { return 1; }
EXPORT const casadi_int *JACOBIAN(_sparsity_in)(casadi_int i) { return i ? column_of_outputs : column_of_inputs; }
EXPORT const casadi_int *JACOBIAN(_sparsity_out)(casadi_int i) { (void)i; return pattern; }
EXPORT int JACOBIAN(_work)(casadi_int *a, casadi_int *r, casadi_int *i, casadi_int *w) { return work(2, a, r, i, w); }
