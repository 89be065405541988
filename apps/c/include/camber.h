/* C interface of Camber, also for Fortran and Julia.

   A mesh is an opaque, immutable handle. The verbs are those of the program, with its words: camber --help, docs/c.md.
   Functions that may fail return a status, 0 for success. After a failure camber_error() describes the error, its place
   and a remedy. Input arrays are copied; output arrays are memory of the caller. Calls from several threads at once are
   allowed; each thread has its own error text. A NULL argument that must not be NULL is an error that names the function
   and the argument: functions with a status return CAMBER_USAGE, the others 0 or NULL. */
#ifndef CAMBER_H
#define CAMBER_H

#include <stddef.h>
#include <stdint.h>

#if defined(_WIN32)
#define CAMBER_API
#else
#define CAMBER_API __attribute__((visibility("default")))
#endif

#ifdef __cplusplus
extern "C" {
#endif

typedef struct camber_mesh camber_mesh;     /* free with camber_free_mesh */
typedef struct camber_result camber_result; /* free with camber_free_result */

typedef enum camber_status {
    CAMBER_OK = 0,
    CAMBER_NOT_CERTIFIED = 1, /* the result does not meet the request: see "misses" in its report */
    CAMBER_USAGE = 2,         /* invalid arguments */
    CAMBER_INPUT = 3,         /* an invalid mesh, field or file, or a failed write */
    CAMBER_INTERNAL = 4,      /* out of memory, or a bug */
    CAMBER_STOPPED = 130      /* stopped by the progress callback */
} camber_status;

CAMBER_API const char* camber_version(void);

/* Error text of this thread's last failed call: "place: error (remedy)". Valid until the thread's next failed call. */
CAMBER_API const char* camber_error(void);

/* ---------------------------------------------------------------- meshes */

/* Read and write files of all formats of the program. `format`: name of a format; NULL: the format of the path's ending. */
CAMBER_API int camber_read(const char* path, camber_mesh** mesh);
CAMBER_API int camber_write(const camber_mesh* mesh, const char* path, const char* format);

/* Cells of one type: "triangle", "tetra", "line" or, for degree 2, "triangle6", "tetra10", "line3". Nodes are stored cell
   by cell, in VTK's order. */
typedef struct camber_cells {
    const char* type;
    int64_t count;
    const int32_t* nodes;
    const int32_t* references; /* one a cell; NULL: all 0 */
} camber_cells;

/* Makes a mesh from points, stored point by point with `dimension` coordinates each. Nodes count from `first`: 0 in C, 1
   in Fortran and Julia. For degree 2 the mesh has the vertices first, in their order, then the nodes of edges. */
CAMBER_API int camber_make(int dimension, int64_t points, const double* coordinates, int types, const camber_cells* cells,
                           int first, camber_mesh** mesh);
CAMBER_API void camber_free_mesh(camber_mesh* mesh);

CAMBER_API int camber_dimension(const camber_mesh* mesh);
CAMBER_API int camber_degree(const camber_mesh* mesh);
CAMBER_API int64_t camber_vertices(const camber_mesh* mesh); /* they are the first points */
CAMBER_API int64_t camber_points(const camber_mesh* mesh);
CAMBER_API int64_t camber_count(const camber_mesh* mesh, const char* type); /* cells of that type */

/* Number (from `first`) of the input point of each mesh point; first - 1: none. The order differs from the input's if the
   vertices of an input of degree 2 are not first. */
CAMBER_API int camber_get_input_points(const camber_mesh* mesh, int first, int64_t* input);
/* Old name: its use is a compile error that states the new name. */
#define camber_get_given camber_get_given_was_renamed_to_camber_get_input_points

/* Copy to arrays of points × dimension, and of cells × nodes of the type; nodes and references may be NULL. */
CAMBER_API int camber_get_points(const camber_mesh* mesh, double* coordinates);
CAMBER_API int camber_get_cells(const camber_mesh* mesh, const char* type, int first, int32_t* nodes, int32_t* references);

/* Makes a mesh with one more field: rows of `components` finite numbers at the vertices or at all points. Verbs transfer
   fields to their result. */
CAMBER_API int camber_with_field(const camber_mesh* mesh, const char* name, int components, int64_t rows,
                                 const double* values, camber_mesh** with);
/* Number of rows (0: no such field) and of components (may be NULL); then the values, rows × components. */
CAMBER_API int64_t camber_field_size(const camber_mesh* mesh, const char* name, int* components);
CAMBER_API int camber_get_field(const camber_mesh* mesh, const char* name, double* values);

/* ---------------------------------------------------------------- verbs */

/* Called repeatedly with a stage and its progress from 0 to 1; any result other than 0 stops the work. */
typedef int (*camber_progress)(const char* stage, double share, void* context);

typedef struct camber_options {
    const double* metric;     /* at the vertices: NULL, or rows of metric_width numbers: 1, a size; D(D+1)/2, the lower */
    int metric_width;         /* triangle of a tensor by rows: xx, xy, yy, xz, yz, zz */
    camber_progress progress; /* may be NULL */
    void* context;
} camber_options;

/* Runs curve, remesh, repair, adapt or check with words of the command line, without input and output, for example
   {"curve", "--metric=0.1"}. A metric in `options` excludes --metric. `options` may be NULL. */
CAMBER_API int camber_run(const camber_mesh* mesh, int words, const char* const* word, const camber_options* options,
                          camber_result** result);
/* Runs a pipeline in JSON (docs/pipelines.md) on the mesh, or on the pipeline's own input if `mesh` is NULL. A metric in
   `options` excludes one in the pipeline. */
CAMBER_API int camber_run_config(const camber_mesh* mesh, const char* json, const camber_options* options,
                                 camber_result** result);

CAMBER_API const camber_mesh* camber_result_mesh(const camber_result* result); /* owned by the result; NULL for check */
CAMBER_API const char* camber_result_report(const camber_result* result);      /* JSON: docs/report.md */
/* Metric at the vertices of the result's mesh: number of rows (0: none) and width (may be NULL); then the values. */
CAMBER_API int64_t camber_result_metric_size(const camber_result* result, int* width);
CAMBER_API int camber_result_metric(const camber_result* result, double* values);
CAMBER_API void camber_free_result(camber_result* result);

#ifdef __cplusplus
}
#endif
#endif
