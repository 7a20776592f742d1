// Spectra to linear Rec. 709 as the RGB variants of Mitsuba 3 do: by the CIE 1931 2 degree observer. Used by the scene
// reader; nothing behind it is spectral.
#pragma once

#include <stddef.h>

#include "math/vec.h"

enum spectrum_use {
    SPECTRUM_REFLECTANCE, // a dimensionless factor: lit by D65, so that a constant spectrum is gray
    SPECTRUM_EMISSION, // radiance, intensity, irradiance: a constant spectrum is the slightly warm white of illuminant
                       // E
};

// Wavelengths [nm] ascending, values at them, linear between and 0 outside; n >= 2. Negative results (colours that Rec.
// 709 cannot show) become 0.
rgb spectrum_rgb(const float *wavelengths_nm, const float *values, size_t n, enum spectrum_use use);
rgb spectrum_uniform_rgb(float value, enum spectrum_use use);
rgb spectrum_blackbody_rgb(double kelvin); // Planck's law in W / (m^2 sr nm), as an emission; kelvin > 0
