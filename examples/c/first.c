/* first [MAP]: renders a frame with its depth, and then finds the camera of that frame again. Plain C99. */
#include "tilemesh.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int failed(tilemesh_handle const* handle)
{
    fprintf(stderr, "first: %s\n", tilemesh_error(handle));
    return 2;
}

/* The numbers of `"start": [...]`, the camera that shows the whole map. A program with a JSON library has no need of this. */
static int start_of(char const* json, double camera[17])
{
    char const* at = json != NULL ? strstr(json, "\"start\":[") : NULL;
    int i;
    for (i = 0; at != NULL && i < 17; ++i) {
        at = strpbrk(at, i == 0 ? "[" : ",");
        if (at != NULL) camera[i] = strtod(++at, NULL);
    }
    return at != NULL;
}

int main(int argc, char** argv)
{
    tilemesh_handle* const handle = tilemesh_create();
    double camera[17], guess[17], found[17], shift = 0;
    float const *depth, *colour;
    double nearest = HUGE_VAL;
    int i, status = 0;
    if (tilemesh_version() < TILEMESH_C_VERSION || handle == NULL) return 2;
    if ((argc > 1 && !tilemesh_load_file(handle, argv[1])) || !tilemesh_set(handle, "{\"width\": 320, \"height\": 180, \"depth\": true}") ||
        !start_of(tilemesh_report(handle, "map"), camera) || !tilemesh_render(handle, camera)) {
        status = failed(handle);
        tilemesh_destroy(handle);
        return status;
    }
    depth = tilemesh_pixels(handle, "depth");
    for (i = 0; i < 320 * 180; ++i)
        if (depth[i] > 0 && depth[i] < nearest) nearest = depth[i];
    printf("320 x 180 pixels, the nearest at depth %.3f\n", nearest);

    memcpy(guess, camera, sizeof guess);
    guess[9] += 0.01; /* off by a hundredth of a unit */
    if (!tilemesh_track_begin(handle, guess, 0)) {
        status = failed(handle);
    } else {
        colour = tilemesh_pixels(handle, "rgb_float"); /* valid until the next call, which copies it */
        if (!tilemesh_track(handle, colour, NULL, 320 * 180, 0.0, found)) {
            status = failed(handle);
        } else {
            for (i = 9; i < 12; ++i) shift += (found[i] - camera[i]) * (found[i] - camera[i]);
            printf("tracked to %.6f units from its camera\n", sqrt(shift));
        }
    }
    tilemesh_destroy(handle);
    return status;
}
