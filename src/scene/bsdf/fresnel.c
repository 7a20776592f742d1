// Diffuse Fresnel reflectance by the polynomial fits that Mitsuba uses too, so that plastics agree with it: inside
// (eta < 1) Egan and Hilgeman 1973, "Optical properties of spatially inhomogeneous materials"; outside d'Eon and
// Irving 2011, "A quantized-diffusion model for rendering translucent materials". The first is 1 % off at eta = 1/1.5.
#include "scene/bsdf/fresnel.h"

float fresnel_diffuse_reflectance(float eta) {
    float inverse = 1.0f / eta;
    if (eta < 1.0f) return ((-1.4399f * eta + 0.7099f) * eta + 0.6681f) + 0.0636f * inverse;
    float sum = -1.36881f;
    const float coefficients[5] = {4.98554f, -7.80989f, 6.75335f, -3.4793f, 0.919317f};
    for (int i = 0; i < 5; ++i) sum = sum * inverse + coefficients[i];
    return sum;
}
