#include "mesh_writer.h"

#include <stdlib.h>
#include <string.h>

void mesh_writer_init(struct mesh_writer *mesh, FILE *file, const char *name) {
    const char *extension = strrchr(name, '.');
    *mesh = (struct mesh_writer){.file = file, .ply = extension && strcmp(extension, ".ply") == 0};
}

static void append(struct mesh_writer *mesh, struct mesh_buffer *buffer, const void *bytes, size_t size) {
    if (buffer->size + size > buffer->capacity) {
        size_t capacity = 2 * buffer->capacity + 65536;
        uint8_t *grown = realloc(buffer->bytes, capacity);
        if (!grown) {
            mesh->failed = true;
            return;
        }
        buffer->bytes = grown;
        buffer->capacity = capacity;
    }
    memcpy(buffer->bytes + buffer->size, bytes, size);
    buffer->size += size;
}

static void append_point(struct mesh_writer *mesh, struct point p) {
    const float v[3] = {(float)p.x, (float)p.y, (float)p.z};
    append(mesh, &mesh->vertex_bytes, v, sizeof v);
}

void mesh_vertex(struct mesh_writer *mesh, struct point p) {
    if (mesh->ply)
        append_point(mesh, p);
    else
        fprintf(mesh->file, "v %.6f %.6f %.6f\n", p.x, p.y, p.z);
    mesh->vertices++;
}

void mesh_vertex_normal(struct mesh_writer *mesh, struct point p, struct point n) {
    mesh->normals = true;
    mesh_vertex(mesh, p);
    if (mesh->ply)
        append_point(mesh, n);
    else
        fprintf(mesh->file, "vn %.5f %.5f %.5f\n", n.x, n.y, n.z);
}

void mesh_vertex_normal_uv(struct mesh_writer *mesh, struct point p, struct point n, double u, double v) {
    mesh->uvs = true;
    mesh_vertex_normal(mesh, p, n);
    fprintf(mesh->file, "vt %.5f %.5f\n", u, 1 - v); // readers of OBJ turn v round
}

void mesh_triangle(struct mesh_writer *mesh, int a, int b, int c) {
    mesh->triangles++;
    if (mesh->ply) {
        const int32_t indices[3] = {a, b, c};
        append(mesh, &mesh->triangle_bytes, &(uint8_t){3}, 1);
        append(mesh, &mesh->triangle_bytes, indices, sizeof indices);
    } else if (mesh->uvs) {
        fprintf(mesh->file, "f %d/%d/%d %d/%d/%d %d/%d/%d\n", a + 1, a + 1, a + 1, b + 1, b + 1, b + 1, c + 1, c + 1,
                c + 1);
    } else if (mesh->normals) {
        fprintf(mesh->file, "f %d//%d %d//%d %d//%d\n", a + 1, a + 1, b + 1, b + 1, c + 1, c + 1);
    } else {
        fprintf(mesh->file, "f %d %d %d\n", a + 1, b + 1, c + 1);
    }
}

void mesh_writer_fini(struct mesh_writer *mesh) {
    if (mesh->ply) {
        fprintf(mesh->file,
                "ply\nformat binary_little_endian 1.0\nelement vertex %d\nproperty float x\nproperty float y\nproperty "
                "float z\n",
                mesh->vertices);
        if (mesh->normals) fputs("property float nx\nproperty float ny\nproperty float nz\n", mesh->file);
        fprintf(mesh->file, "element face %d\nproperty list uchar int vertex_indices\nend_header\n", mesh->triangles);
        fwrite(mesh->vertex_bytes.bytes, 1, mesh->vertex_bytes.size, mesh->file);
        fwrite(mesh->triangle_bytes.bytes, 1, mesh->triangle_bytes.size, mesh->file);
    }
    free(mesh->vertex_bytes.bytes);
    free(mesh->triangle_bytes.bytes);
}
