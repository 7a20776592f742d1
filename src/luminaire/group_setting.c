#include "luminaire/group_setting.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "format/spectrum.h"

static const char spaces[] = " \t\r\n";
enum { NONE = -1, ALL = -2 }; // in place of a group's index
static const double coldest = 1000, hottest = 100000; // [K]

float luminous_flux(const float flux[3]) { return LUMENS_PER_WATT * rgb_luminance((rgb){flux[0], flux[1], flux[2]}); }

enum status group_name_check(const char *name, struct error *error) {
    size_t length = strlen(name);
    if (length >= 1 && length < LUMINAIRE_NAME_SIZE && !strpbrk(name, ",;= \t\r\n") && strcmp(name, GROUP_ALL))
        return STATUS_OK;
    return error_set(error, STATUS_INVALID,
                     "'%.80s' cannot name a group of emitters: names have 1 to %d characters, no commas, semicolons, "
                     "equals signs and spaces, and '%s' is the whole lamp",
                     name, LUMINAIRE_NAME_SIZE - 1, GROUP_ALL);
}

struct lamp_setting { // of one group, or of all
    bool has_kelvin, has_lumens;
    double kelvin, lumens;
    float factor[3];
};

static enum status refuse(const char *setting, size_t length, struct error *error) {
    return error_set(error, STATUS_INVALID,
                     "'%.*s' is no setting of a group; write a factor (0.3), three of them (1:0.8:0.6), a colour "
                     "temperature from %g to %g K (2700K), or a luminous flux (800lm)",
                     (int)length, setting, coldest, hottest);
}

// Numbers between colons with a unit behind: [0, length) of `text`.
static enum status read_word(const char *text, size_t length, struct lamp_setting *setting, struct error *error) {
    char word[64], *end = word;
    double numbers[3];
    int count = 0;
    if (length >= sizeof word) return refuse(text, length, error);
    memcpy(word, text, length);
    word[length] = 0;
    for (const char *at = word; count < 3; at = end + 1) {
        numbers[count] = strtod(at, &end);
        if (end == at || !(numbers[count] >= 0 && numbers[count] <= 1e9)) return refuse(text, length, error);
        count++;
        if (*end != ':') break;
    }
    if (!strcmp(end, "K") && count == 1 && numbers[0] >= coldest && numbers[0] <= hottest && !setting->has_kelvin) {
        setting->has_kelvin = true;
        setting->kelvin = numbers[0];
    } else if (!strcmp(end, "lm") && count == 1 && !setting->has_lumens) {
        setting->has_lumens = true;
        setting->lumens = numbers[0];
    } else if (!*end && count != 2) {
        for (int c = 0; c < 3; c++) setting->factor[c] *= (float)numbers[count == 3 ? c : 0];
    } else {
        return refuse(text, length, error);
    }
    return STATUS_OK;
}

static enum status read_setting(const char *text, size_t length, struct lamp_setting *setting, struct error *error) {
    *setting = (struct lamp_setting){.factor = {1, 1, 1}};
    const char *end = text + length;
    bool any = false;
    for (const char *at = text; at < end;) {
        at += strspn(at, spaces);
        size_t n = strcspn(at, " \t\r\n;,");
        if (at >= end || !n) break;
        enum status status = read_word(at, n, setting, error);
        if (status) return status;
        any = true;
        at += n;
    }
    return any ? STATUS_OK : refuse(text, length, error);
}

static bool is_chosen(size_t index, int group) { return group == ALL || (int)index == group; }

// Of the chosen groups with their factors so far.
static rgb light_of(const struct group_light *groups, size_t count, int group) {
    rgb sum = {0, 0, 0};
    for (size_t g = 0; g < count; g++)
        if (is_chosen(g, group))
            sum = rgb_add(sum, (rgb){groups[g].flux[0] * groups[g].factor[0], groups[g].flux[1] * groups[g].factor[1],
                                     groups[g].flux[2] * groups[g].factor[2]});
    return sum;
}

static void scale(struct group_light *groups, size_t count, int group, const float factor[3]) {
    for (size_t g = 0; g < count; g++)
        for (int c = 0; c < 3 && is_chosen(g, group); c++) groups[g].factor[c] *= factor[c];
}

static enum status apply(struct group_light *groups, size_t count, int group, const struct lamp_setting *setting,
                         struct error *error) {
    const char *name = group == ALL ? GROUP_ALL : groups[group].name;
    rgb light = light_of(groups, count, group);
    double luminance = (double)rgb_luminance(light);
    if ((setting->has_kelvin || setting->has_lumens) && !(luminance > 0))
        return error_set(error, STATUS_INVALID, "'%s' is dark: it has no colour and no flux to set", name);
    if (setting->has_kelvin) {
        rgb body = spectrum_blackbody_rgb(setting->kelvin);
        const float from[3] = {light.r, light.g, light.b}, to[3] = {body.r, body.g, body.b};
        float factor[3];
        for (int c = 0; c < 3; c++) {
            double wanted = (double)to[c] * luminance / (double)rgb_luminance(body);
            if (wanted > 0 && !(from[c] > 0))
                return error_set(error, STATUS_INVALID,
                                 "'%s' has no %s light, so that its colour cannot become that of %g K; give it "
                                 "factors, or bake it with a whiter radiance",
                                 name, (const char *const[]){"red", "green", "blue"}[c], setting->kelvin);
            factor[c] = wanted > 0 ? (float)(wanted / (double)from[c]) : 0;
        }
        scale(groups, count, group, factor);
    }
    if (setting->has_lumens) {
        float factor = (float)(setting->lumens / (LUMENS_PER_WATT * luminance));
        scale(groups, count, group, (const float[3]){factor, factor, factor});
    }
    scale(groups, count, group, setting->factor);
    return STATUS_OK;
}

static enum status unknown_name(const char *name, size_t length, const struct group_light *groups, size_t count,
                                struct error *error) {
    char list[300] = "";
    size_t used = 0;
    for (size_t g = 0; g < count && used < sizeof list; g++)
        if (groups[g].name)
            used += (size_t)snprintf(list + used, sizeof list - used, "%s%s", used ? ", " : "", groups[g].name);
    if (!used)
        return error_set(error, STATUS_INVALID,
                         "there is no group '%.*s': this lamp was baked without groups; set '%s', or bake it with "
                         "--groups",
                         (int)length, name, GROUP_ALL);
    return error_set(error, STATUS_INVALID, "there is no group '%.*s'; this lamp has %s, and '%s' is the whole lamp",
                     (int)length, name, list, GROUP_ALL);
}

// Reads the name before '='; *at is left behind it.
static enum status read_name(const char **at, const struct group_light *groups, size_t count, int *group,
                             struct error *error) {
    size_t length = strcspn(*at, "=;,");
    const char *name = *at;
    if (name[length] != '=')
        return error_set(error, STATUS_INVALID, "'%.*s' is not NAME=SETTING, as in 'bulb=0.3; spot=2700K'", (int)length,
                         name);
    *at += length + 1;
    while (length && strchr(spaces, name[length - 1])) length--;
    *group = NONE;
    if (length == strlen(GROUP_ALL) && !strncmp(name, GROUP_ALL, length)) *group = ALL;
    for (size_t g = 0; g < count && *group == NONE; g++)
        if (groups[g].name && strlen(groups[g].name) == length && !strncmp(name, groups[g].name, length))
            *group = (int)g;
    return *group == NONE ? unknown_name(name, length, groups, count, error) : STATUS_OK;
}

enum status group_settings_apply(const char *text, struct group_light *groups, size_t count, struct error *error) {
    bool *set = calloc(count + 1, sizeof *set); // the last one: all
    if (!set) return error_set(error, STATUS_MEMORY, "out of memory for %zu groups", count);
    enum status status = STATUS_OK;
    for (const char *at = text + strspn(text, " \t\r\n;,"); *at && !status; at += strspn(at, " \t\r\n;,")) {
        int group;
        struct lamp_setting setting;
        status = read_name(&at, groups, count, &group, error);
        if (status) break;
        size_t length = strcspn(at, ";,"), slot = group == ALL ? count : (size_t)group;
        status = read_setting(at, length, &setting, error);
        if (!status && set[slot])
            status =
                error_set(error, STATUS_INVALID, "'%s' is set twice", group == ALL ? GROUP_ALL : groups[slot].name);
        set[slot] = true;
        if (!status) status = apply(groups, count, group, &setting, error);
        at += length;
    }
    free(set);
    return status;
}
