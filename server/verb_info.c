// verb_info.c - `glintd info`: what this program, this machine and given files
// hold, as text.
#include "server/verbs.h"

#include <stdio.h>
#include <stdlib.h>

#include "protocol/schema.h"
#include "renderer/groom.h"
#include "renderer/renderer.h"
#include "renderer/sky.h"
#include "server/assets.h"
#include "server/cache.h"
#include "server/options.h"
#include "server/version.h"

static void print_hair(const struct assets_hair *h)
{
    const struct groom *g = h->groom;
    printf("hair %s\n  sha256 %s\n  strands %u, points %u\n", h->source.name,
           h->source.sha256, g->strands, g->points);
    printf("  box (%g, %g, %g) to (%g, %g, %g), up %c\n", (double)g->box_min[0],
           (double)g->box_min[1], (double)g->box_min[2], (double)g->box_max[0],
           (double)g->box_max[1], (double)g->box_max[2], "xyz"[g->up]);
    if (g->diameter)
        printf("  diameter per point\n");
    else if (g->default_diameter > 0)
        printf("  diameter %g\n", (double)g->default_diameter);
    else
        printf("  diameter not given; automatic %g\n",
               (double)groom_auto_diameter(g));
    printf("  opacity %s, colour %s, head %s\n",
           g->opacity ? "per point" : "one", g->colour ? "per point" : "one",
           g->head.present ? "yes" : "no");
}

static void print_sky(const struct assets_sky *s)
{
    const struct sky_cleaned *c = &s->map->cleaned;
    printf("env %s\n  sha256 %s\n  %d x %d\n", s->source.name, s->source.sha256,
           s->width, s->height);
    printf("  cleaned: %llu negative, %llu nan, %llu infinite; %.3g of the "
           "energy\n",
           (unsigned long long)c->negative, (unsigned long long)c->nan,
           (unsigned long long)c->infinite, c->energy_share);
}

static bool print_files(const struct options *o, struct error *err)
{
    struct assets_hair hair;
    struct assets_sky sky;
    if (o->hair_given) {
        if (!assets_hair_load(&hair, o->hair, NULL, err))
            return false;
        print_hair(&hair);
        assets_hair_finish(&hair);
    }
    if (o->env_given) {
        if (!assets_sky_load(&sky, o->env, NULL, err))
            return false;
        print_sky(&sky);
        assets_sky_finish(&sky);
    }
    return true;
}

static bool print_general(struct error *err)
{
    struct renderer *r = renderer_create(NULL, err);
    if (!r)
        return false;
    printf("glintd %s, protocol %d\n", VERSION_PROGRAM, VERSION_PROTOCOL);
    printf("device %s\n", renderer_device(r));
    renderer_destroy(r);
    char *cache = cache_directory();
    printf("cache %s\n", cache ? cache : "none");
    free(cache);
    printf("grooms");
    for (int i = 0; groom_builtin_names[i]; i++)
        printf(" builtin:%s", groom_builtin_names[i]);
    printf("\nskies");
    for (int i = 0; sky_builtin_names[i]; i++)
        printf(" builtin:%s", sky_builtin_names[i]);
    printf("\nparameters %d (--params lists them)\n", params_row_count);
    return true;
}

int verb_info_run(int argc, char **argv)
{
    bool params = false;
    const struct options_row rows[] = {{"params", OPTIONS_FLAG, &params, 0, 0,
                                        NULL,
                                        "the table of parameters, as Markdown"},
                                       {0}};
    const struct options_verb verb = {
        .name = "info",
        .about = "tells about the device, what is built in, and given files",
        .takes = OPTIONS_HAIR | OPTIONS_ENV,
        .rows = rows,
    };
    struct options o;
    struct error err = {0};
    int status = options_parse(&o, &verb, argc, argv);
    if (status < 0 && params) {
        struct buf text = {0};
        schema_markdown(&text);
        fwrite(text.data, 1, text.size, stdout);
        buf_finish(&text);
        status = 0;
    } else if (status < 0) {
        bool ok = o.hair_given || o.env_given ? print_files(&o, &err)
                                              : print_general(&err);
        status = ok ? 0 : options_fail(&err);
    }
    options_finish(&o);
    return status;
}
