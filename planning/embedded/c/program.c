#include "program.h"

#include <math.h>
#include <string.h>

double dot(const double *a, const double *b, int n) {
  double sum = 0.0;
  for (int i = 0; i < n; i++) sum += a[i] * b[i];
  return sum;
}

double entry_value(const program *p, const double *x, int entry) {
  return entry < WIDTH ? x[entry] : dot(p->rows[entry - WIDTH], x, WIDTH);
}

void add_entry(const program *p, int entry, double factor, double *sum) {
  if (entry < WIDTH) {
    sum[entry] += factor;
    return;
  }
  for (int j = 0; j < WIDTH; j++) sum[j] += factor * p->rows[entry - WIDTH][j];
}

int is_fixed(const program *p, int entry) {
  return entry >= FIRST_EQUALITY || p->lower[entry] == p->upper[entry];
}

void program_start(program *p) {
  memset(p, 0, sizeof *p);
  memcpy(p->rows, CARTGRASP_ROWS, sizeof CARTGRASP_ROWS);
  memcpy(p->lower, CARTGRASP_LOWER, sizeof CARTGRASP_LOWER);
  memcpy(p->upper, CARTGRASP_UPPER, sizeof CARTGRASP_UPPER);
}

void program_set_wrench(program *p, const double wrench_b[3]) {
  for (int k = 0; k < CARTGRASP_FREE; k++) {
    double value = 0.0;
    for (int i = 0; i < 3; i++) value += CARTGRASP_BASIS_B[i][k] * wrench_b[i];
    p->lower[FIRST_EQUALITY + k] = p->upper[FIRST_EQUALITY + k] = value;
  }
}

/* Columns fx, fy and tz of the planar grasp map at a contact: what they do on the cart as (fx, fy, tau). */
static void grasp_map(const double contact_b[3], double yaw, double map[3][3]) {
  const double c = cos(yaw), s = sin(yaw), x = contact_b[0], y = contact_b[1];
  const double columns[3][3] = {{c, s, x * s - y * c}, {-s, c, x * c + y * s}, {0.0, 0.0, 1.0}};
  memcpy(map, columns, sizeof columns);
}

void program_set_contacts(program *p, const double contacts_b[][3], double *changed) {
  static const int components[3] = {0, 1, 5};
  for (int arm = 0; arm < CARTGRASP_ARMS; arm++) {
    double map[3][3];
    grasp_map(contacts_b[arm], CARTGRASP_YAWS[arm], map);
    for (int k = 0; k < CARTGRASP_FREE; k++) {
      for (int j = 0; j < 3; j++) {
        double value = 0.0;
        for (int i = 0; i < 3; i++) value += CARTGRASP_BASIS_B[i][k] * map[j][i];
        p->rows[CARTGRASP_LIMIT_ROWS + k][6 * arm + components[j]] = value;
        *changed++ = value;
      }
    }
  }
}
