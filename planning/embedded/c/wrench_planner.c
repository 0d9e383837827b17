#include "wrench_planner.h"

#include <math.h>
#include <string.h>

#include "cartgrasp_osqp_workspace.h"
#include "osqp.h"
#include "program.h"
#include "types.h"

#define RHO 0.1 /* OSQP's first step size, which it adapts: what it proposes doesn't depend on earlier calls */

/* OSQP only proposes: its tolerance and its iterations decide how good a proposal is, never what is proven. */
static const struct {
  int iterations;
  double tolerance;
} rounds[] = {{100, 1e-3}, {500, 1e-5}, {CARTGRASP_MOST_ITERATIONS - 600, 1e-9}};

static program problem;
static point last; /* the last optimal plan, from whose active set the next one starts */
static double contacts[CARTGRASP_ARMS][3];
static int is_started;

static int within(const double *values, int n, double largest) {
  for (int i = 0; i < n; i++) {
    if (!(fabs(values[i]) <= largest)) return 0;
  }
  return 1;
}

static void set_contacts(const double contacts_b[][3]) {
  double changed[WIDTH * CARTGRASP_CONTACT_ROWS];
  memcpy(contacts, contacts_b, sizeof contacts);
  program_set_contacts(&problem, contacts_b, changed);
  osqp_update_data_mat(&cartgrasp_osqp_solver, NULL, NULL, 0, changed, CARTGRASP_CONTACT_ENTRIES,
                       WIDTH * CARTGRASP_CONTACT_ROWS);
}

static void start(void) {
  program_start(&problem);
  set_contacts(CARTGRASP_CONTACTS_B);
  is_started = 1;
}

/* OSQP can't hold infinity: its own stands for it. */
static void hand_over_limits(void) {
  double lower[ENTRIES], upper[ENTRIES];
  for (int i = 0; i < ENTRIES; i++) {
    lower[i] = fmax(problem.lower[i], -OSQP_INFTY);
    upper[i] = fmin(problem.upper[i], OSQP_INFTY);
  }
  osqp_update_data_vec(&cartgrasp_osqp_solver, NULL, lower, upper);
}

static void run_osqp(int iterations, double tolerance) {
  OSQPSettings settings = *cartgrasp_osqp_solver.settings;
  settings.max_iter = iterations;
  settings.eps_abs = settings.eps_rel = settings.eps_prim_inf = tolerance;
  osqp_update_settings(&cartgrasp_osqp_solver, &settings);
  osqp_solve(&cartgrasp_osqp_solver);
}

static int take(cartgrasp_plan *plan, point *found) {
  if (!polish(&problem, found) || !verify(&problem, found, &plan->residuals)) return 0;
  last = *found;
  plan->status = CARTGRASP_OPTIMAL;
  for (int i = 0; i < WIDTH; i++) plan->effort += CARTGRASP_WEIGHTS[i] * found->x[i] * found->x[i];
  memcpy(plan->wrenches_a, found->x, sizeof plan->wrenches_a);
  return 1;
}

static int take_ray(cartgrasp_plan *plan, double *ray) {
  polish_ray(&problem, ray);
  if (!certify(&problem, ray, &plan->certificate)) return 0;
  plan->status = CARTGRASP_INFEASIBLE;
  return 1;
}

/* Where there is no solution, OSQP's multipliers grow along a ray; it leaves their last step in delta_y when it
   is sure. */
static int take_proposal(cartgrasp_plan *plan) {
  const OSQPSolution *proposed = cartgrasp_osqp_solver.solution;
  const OSQPInt claim = cartgrasp_osqp_solver.info->status_val;
  double ray[ENTRIES];
  if (claim == OSQP_PRIMAL_INFEASIBLE || claim == OSQP_PRIMAL_INFEASIBLE_INACCURATE) {
    OSQPVectorf_to_raw(ray, cartgrasp_osqp_solver.work->delta_y);
    return take_ray(plan, ray);
  }
  point found;
  memcpy(found.x, proposed->x, sizeof found.x);
  memcpy(found.y, proposed->y, sizeof found.y);
  memcpy(ray, proposed->y, sizeof ray);
  if (take(plan, &found) || take_ray(plan, ray)) return 1;
  memcpy(found.x, proposed->x, sizeof found.x);
  memset(found.y, 0, sizeof found.y);
  return approach(&problem, &found) && take_ray(plan, found.y);
}

static void solve(cartgrasp_plan *plan) {
  point guess = last;
  if (take(plan, &guess)) return;
  hand_over_limits();
  osqp_cold_start(&cartgrasp_osqp_solver);
  osqp_update_rho(&cartgrasp_osqp_solver, RHO);
  for (int i = 0; i < (int)(sizeof rounds / sizeof rounds[0]); i++) {
    run_osqp(rounds[i].iterations, rounds[i].tolerance);
    plan->iterations += (int)cartgrasp_osqp_solver.info->iter;
    if (take_proposal(plan)) return;
  }
  plan->status = CARTGRASP_NUMERICAL;
}

enum cartgrasp_status cartgrasp_plan_wrench(const double wrench_b[3], const double (*contacts_b)[3],
                                            cartgrasp_plan *plan) {
  memset(plan, 0, sizeof *plan);
  plan->status = CARTGRASP_INVALID_INPUT;
  if (!within(wrench_b, 3, CARTGRASP_MAX_WRENCH)) return plan->status;
  if (contacts_b && !within(contacts_b[0], 3 * CARTGRASP_ARMS, CARTGRASP_MAX_POSITION)) return plan->status;
  if (!is_started) start();
  if (contacts_b && memcmp(contacts, contacts_b, sizeof contacts) != 0) set_contacts(contacts_b);
  program_set_wrench(&problem, wrench_b);
  solve(plan);
  return plan->status;
}

const char *cartgrasp_status_name(enum cartgrasp_status status) {
  static const char *const names[] = {"optimal", "infeasible", "invalid_input", "numerical"};
  return names[status];
}
