/* A controller library with the Bladed interface for the tests.

   The first line of its input file is a gain and a word: pitch = gain (generator speed - 100), torque = 10 generator
   speed, yaw rate (record 48) = number of calls. It copies records 1 to 100 to 2001 to 2100 and 1001 to 2101, and
   writes status and time of each call to OUTNAME.log. The word makes trouble from t = 0.5 s on. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static int calls; /* as in a Fortran module: one for the loaded library */
static double gain;
static char word[40];

void DISCON(float *swap, int *flag, char *input, char *output, char *message) {
    float *record = swap - 1; /* counted from 1 */
    char name[1100];
    int individual = record[28] == 1;
    if (record[1] == 0) {
        FILE *file = fopen(input, "r");
        if (!file || fscanf(file, "%lf %39s", &gain, word) != 2 || strlen(input) + 1 != (size_t)record[50]) {
            *flag = -1;
            snprintf(message, (size_t)record[49], "cannot read '%s'", input);
            return;
        }
        fclose(file);
        printf("hello from the controller\n");
        fflush(stdout);
    }
    calls++;
    for (int i = 1; i <= 100; i++) record[2000 + i] = record[i];
    record[2101] = record[1001];
    for (int i = 0; i < 3; i++) record[42 + i] = (float)(gain * (record[20] - 100) + 0.01 * i);
    record[45] = individual ? 77 : record[42];
    record[47] = 10 * record[20];
    record[48] = (float)calls;
    snprintf(name, sizeof name, "%s.log", output);
    FILE *log = fopen(name, "a");
    if (log) {
        fprintf(log, "%d %.7g\n", (int)record[1], record[2]);
        fclose(log);
    }
    if (record[2] < 0.4999 || record[1] < 0) return;
    if (!strcmp(word, "fail")) { *flag = -1; strcpy(message, "the generator is too hot"); }
    if (!strcmp(word, "warn")) { *flag = 1; strcpy(message, "the wind is strong"); }
    if (!strcmp(word, "crash")) abort();
    if (!strcmp(word, "leave")) exit(3);
    if (!strcmp(word, "hang")) sleep(60);
    if (!strcmp(word, "brake")) record[36] = 1;
    if (!strcmp(word, "off")) record[35] = 0;
    if (!strcmp(word, "nan")) record[47] = NAN;
}
