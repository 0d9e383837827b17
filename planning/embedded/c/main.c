/* Reads wrenches, one a line: fx fy tau, and a contact x y z for each arm where contacts are to change. Prints a
   plan for each: its status; when optimal its effort and fx fy fz tx ty tz of each arm; when infeasible the
   certificate's direction (fx fy tau), what is asked along it and the most there is. Blank lines and lines that
   begin with # are skipped. With --time it prints only how long plans took. */

#define _POSIX_C_SOURCE 199309L

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "wrench_planner.h"

#define MAX_NUMBERS (3 + 3 * CARTGRASP_ARMS)
#define MAX_TIMES 100000

static double times[MAX_TIMES]; /* microseconds; of more plans than fit the last ones */
static int n_plans;

/* How many numbers a line holds; -1 if there is anything else in it, or more of them than fit. */
static int read_numbers(const char *text, double *numbers) {
  for (int n = 0;; n++) {
    char *stop;
    const double value = strtod(text, &stop);
    if (stop == text) {
      while (*text == ' ' || *text == '\t' || *text == '\r' || *text == '\n') text++;
      return *text ? -1 : n;
    }
    if (n == MAX_NUMBERS) return -1;
    numbers[n] = value;
    text = stop;
  }
}

static void print_numbers(const double *numbers, int n) {
  for (int i = 0; i < n; i++) printf(" %.17g", numbers[i]);
}

static void print_plan(const cartgrasp_plan *plan) {
  printf("%s", cartgrasp_status_name(plan->status));
  if (plan->status == CARTGRASP_OPTIMAL) {
    print_numbers(&plan->effort, 1);
    print_numbers(plan->wrenches_a[0], 6 * CARTGRASP_ARMS);
  } else if (plan->status == CARTGRASP_INFEASIBLE) {
    print_numbers(plan->certificate.direction_b, 3);
    print_numbers(&plan->certificate.asked, 1);
    print_numbers(&plan->certificate.most, 1);
  }
  printf("\n");
}

static double clock_in_us(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return 1e6 * (double)now.tv_sec + 1e-3 * (double)now.tv_nsec;
}

static int ascending(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

static void print_times(void) {
  const int n = n_plans < MAX_TIMES ? n_plans : MAX_TIMES;
  if (n == 0) return;
  qsort(times, (size_t)n, sizeof(double), ascending);
  printf("%d plans, us each: median %.1f, 99 of 100 under %.1f, most %.1f\n", n_plans, times[n / 2],
         times[(int)(0.99 * n)], times[n - 1]);
}

int main(int argc, char **argv) {
  const int is_timed = argc > 1 && strcmp(argv[1], "--time") == 0;
  static char line[64 * MAX_NUMBERS];
  double numbers[MAX_NUMBERS];
  cartgrasp_plan plan;
  for (int count = 1; fgets(line, sizeof line, stdin); count++) {
    const int n = line[0] == '#' ? 0 : read_numbers(line, numbers);
    if (n == 0) continue;
    if (n != 3 && n != MAX_NUMBERS) {
      fprintf(stderr, "line %d: 3 numbers (fx fy tau) are needed, or %d with contacts\n", count, MAX_NUMBERS);
      return 2;
    }
    double contacts_b[CARTGRASP_ARMS][3];
    for (int i = 0; i < n - 3; i++) contacts_b[i / 3][i % 3] = numbers[3 + i];
    const double start = clock_in_us();
    cartgrasp_plan_wrench(numbers, n == 3 ? NULL : (const double(*)[3])contacts_b, &plan);
    times[n_plans++ % MAX_TIMES] = clock_in_us() - start;
    if (!is_timed) print_plan(&plan);
  }
  if (is_timed) print_times();
  return 0;
}
