#include "scene_writer.h"

#include <string.h>

void scene_begin(FILE *file, const char *comment, struct point camera, struct point target, double fov) {
    fprintf(file,
            "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n"
            "<!-- %s -->\n"
            "<scene version=\"3.0.0\">\n"
            "    <integrator type=\"path\">\n"
            "        <integer name=\"max_depth\" value=\"32\"/>\n"
            "    </integrator>\n"
            "    <sensor type=\"perspective\">\n"
            "        <float name=\"fov\" value=\"%g\"/>\n"
            "        <transform name=\"to_world\">\n"
            "            <lookat origin=\"%g, %g, %g\" target=\"%g, %g, %g\" up=\"0, 1, 0\"/>\n"
            "        </transform>\n"
            "        <sampler type=\"independent\"><integer name=\"sample_count\" value=\"64\"/></sampler>\n"
            "        <film type=\"hdrfilm\">\n"
            "            <integer name=\"width\" value=\"480\"/>\n"
            "            <integer name=\"height\" value=\"480\"/>\n"
            "        </film>\n"
            "    </sensor>\n",
            comment, fov, camera.x, camera.y, camera.z, target.x, target.y, target.z);
}

void scene_end(FILE *file) { fputs("</scene>\n", file); }

void scene_dielectric(FILE *file, const char *id, double int_ior, double ext_ior) {
    fprintf(file,
            "    <bsdf type=\"dielectric\" id=\"%s\">\n"
            "        <float name=\"int_ior\" value=\"%.1f\"/>\n"
            "        <float name=\"ext_ior\" value=\"%.1f\"/>\n"
            "    </bsdf>\n",
            id, int_ior, ext_ior);
}

void scene_rough_glass(FILE *file, const char *id, double alpha, const char *tint) {
    fprintf(file,
            "    <bsdf type=\"roughdielectric\" id=\"%s\">\n"
            "        <string name=\"distribution\" value=\"ggx\"/>\n"
            "        <float name=\"alpha\" value=\"%g\"/>\n"
            "        <float name=\"int_ior\" value=\"1.5\"/>\n"
            "        <float name=\"ext_ior\" value=\"1.0\"/>\n"
            "        <rgb name=\"specular_reflectance\" value=\"%s\"/>\n"
            "        <rgb name=\"specular_transmittance\" value=\"%s\"/>\n"
            "    </bsdf>\n",
            id, alpha, tint, tint);
}

void scene_metal(FILE *file, const char *id, double alpha, const char *eta, const char *k) {
    fprintf(file,
            "    <bsdf type=\"roughconductor\" id=\"%s\">\n"
            "        <float name=\"alpha\" value=\"%g\"/>\n"
            "        <rgb name=\"eta\" value=\"%s\"/>\n"
            "        <rgb name=\"k\" value=\"%s\"/>\n"
            "    </bsdf>\n",
            id, alpha, eta, k);
}

void scene_brass(FILE *file, const char *id, double alpha) {
    scene_metal(file, id, alpha, "0.444, 0.527, 1.094", "3.695, 2.765, 1.829");
}

void scene_sphere(FILE *file, struct point center, double radius, const char *inside) {
    fprintf(file,
            "    <shape type=\"sphere\">\n"
            "        <point name=\"center\" x=\"%.6f\" y=\"%.6f\" z=\"%.6f\"/>\n"
            "        <float name=\"radius\" value=\"%g\"/>\n"
            "        %s\n"
            "    </shape>\n",
            center.x, center.y, center.z, radius, inside);
}

void scene_mesh(FILE *file, const char *id, const char *name, bool flat, const char *inside) {
    fprintf(file,
            "    <shape type=\"%s\" id=\"%s\">\n"
            "        <string name=\"filename\" value=\"%s\"/>\n"
            "%s"
            "        %s\n"
            "    </shape>\n",
            strrchr(name, '.') + 1, id, name, flat ? "        <boolean name=\"face_normals\" value=\"true\"/>\n" : "",
            inside);
}
