// The manual pages of plugins, written by their tables of parameters.
#include "scene/help.h"

#include <string.h>

#include "format/description.h"
#include "scene/plugins.h"

static const char *const type_names[] = {
    [PARAM_BOOL] = "boolean",  [PARAM_INT] = "integer",         [PARAM_FLOAT] = "float",
    [PARAM_STRING] = "string", [PARAM_CHOICE] = "string",       [PARAM_RGB] = "rgb",
    [PARAM_VEC3] = "point",    [PARAM_TRANSFORM] = "transform", [PARAM_TEXTURE] = "rgb, texture"};

// Each step copies the text so far: pages are short.
static char *append_param(struct arena *arena, char *text, const struct param *p) {
    const char *unit = p->unit && strcmp(p->unit, "1") ? p->unit : "";
    if (text) text = arena_printf(arena, "%s  %-24s %-13s", text, p->name, type_names[p->type]);
    if (text) text = arena_printf(arena, "%s%s\n", text, p->help ? p->help : "");
    if (text && p->choices && p->type == PARAM_CHOICE)
        text = arena_printf(arena, "%s%41sone of %s\n", text, "", p->choices);
    if (text && p->choices && p->type == PARAM_STRING)
        text = arena_printf(arena, "%s%41sas in %s\n", text, "", p->choices);
    if (text && p->alias) text = arena_printf(arena, "%s%41salso called %s\n", text, "", p->alias);
    if (text && p->min < p->max)
        text = arena_printf(arena, "%s%41sfrom %g to %g%s%s\n", text, "", p->min, p->max, *unit ? " " : "", unit);
    else if (text && *unit)
        text = arena_printf(arena, "%s%41sin %s\n", text, "", unit);
    if (text && !p->fallback)
        text = arena_printf(arena, "%s%41srequired\n", text, "");
    else if (text && *p->fallback)
        text = arena_printf(arena, "%s%41sdefault %s\n", text, "", p->fallback);
    return text;
}

static bool declares(const struct param *params, const char *name) {
    for (; params && params->name; params++)
        if (param_name_equal(params->name, name)) return true;
    return false;
}

static char *type_page(struct arena *arena, const struct plugin_view *view) {
    char *text = arena_printf(arena, "<%s type=\"%s\">: %s\n", view->tag, view->name, view->help ? view->help : "");
    bool any = view->max_nested > 0;
    if (text && any && view->min_nested == view->max_nested)
        text = arena_printf(arena, "%s  nested bsdfs: %d\n", text, view->max_nested);
    else if (text && any)
        text = arena_printf(arena, "%s  nested bsdfs: %d to %d\n", text, view->min_nested, view->max_nested);
    for (const struct param *p = view->params; text && p && p->name; p++, any = true)
        text = append_param(arena, text, p);
    for (const struct param *p = view->common; text && p && p->name; p++)
        if (!declares(view->params, p->name)) text = append_param(arena, text, p), any = true;
    if (text && !any) text = arena_printf(arena, "%s  no parameters\n", text);
    return text;
}

static char *append_types(struct arena *arena, char *text, const char *tag) {
    struct plugin_view view;
    if (text) text = arena_printf(arena, "%s%s\n", text, tag);
    for (size_t i = 0; text && plugin_at(tag, i, &view); i++)
        text = arena_printf(arena, "%s  %-18s %s\n", text, view.name, view.help ? view.help : "");
    return text;
}

static const char *known_tag(const char *tag) {
    for (const char *const *t = plugin_tags; *t; t++)
        if (param_name_equal(*t, tag)) return *t;
    return NULL;
}

bool help_knows(const char *tag, const char *type) {
    struct plugin_view view;
    size_t index;
    return !tag || (known_tag(tag) && (!type || plugin_find(known_tag(tag), type, &view, &index)));
}

char *help_text(struct arena *arena, const char *tag, const char *type) {
    struct plugin_view view;
    size_t index, tag_count = 0;
    const char *known = tag ? known_tag(tag) : NULL;
    if (known && type && plugin_find(known, type, &view, &index)) return type_page(arena, &view);
    char *text = arena_strdup(arena, "");
    while (plugin_tags[tag_count]) tag_count++;
    if (known && type && text) {
        const char *near = plugin_nearest(known, type);
        text = arena_printf(arena, "there is no %s '%s'%s%s%s\n", known, type, near ? "; did you mean '" : "",
                            near ? near : "", near ? "'?" : "");
    }
    if (tag && !known && text) {
        const char *near = nearest_name(tag, plugin_tags, tag_count);
        text = arena_printf(arena, "there is nothing called '%s'%s%s%s\n", tag, near ? "; did you mean '" : "",
                            near ? near : "", near ? "'?" : "");
    }
    if (known) return append_types(arena, text, known);
    for (size_t i = 0; i < tag_count; i++) text = append_types(arena, text, plugin_tags[i]);
    return text;
}
