// rehearsal.c - which draft is made next at rest.
#include "server/rehearsal.h"

void rehearsal_ask(const struct renderer *r, const struct params *p,
                   struct haste_ask *ask)
{
    struct renderer_stats stats;
    renderer_stats(r, &stats);
    *ask = (struct haste_ask){
        .budget_ms = (double)p->quality.draft_ms,
        .height = p->image.height,
        .width_pixels = stats.strand_pixels,
    };
    ask->seen_count = renderer_drafts_seen(r, ask->seen);
}

static bool is_seen(const struct haste_ask *ask,
                    const struct renderer_draft *how)
{
    for (int i = 0; i < ask->seen_count; i++)
        if (ask->seen[i].divisor == how->divisor &&
            ask->seen[i].stride == how->stride)
            return true;
    return false;
}

// What is edited most comes last: what it needs is certainly there then.
bool rehearsal_next(struct haste *h, struct renderer *r, const struct params *p)
{
    static const enum renderer_stage first[] = {
        RENDERER_STRANDS, RENDERER_VISIBLE, RENDERER_CROSSINGS, RENDERER_FIBRE};
    struct haste_ask ask;
    rehearsal_ask(r, p, &ask);
    ask.resting = true;
    for (size_t i = 0; i < sizeof first / sizeof first[0]; i++) {
        double forecast[RENDERER_STAGES], ms[RENDERER_STAGES];
        struct renderer_draft how;
        const bool keeps =
            first[i] == RENDERER_CROSSINGS || first[i] == RENDERER_FIBRE;
        if (!renderer_foresee(r, first[i], forecast))
            return false;
        if (!haste_choose(h, forecast, &ask, &how) ||
            (haste_settled(h, forecast, &how) &&
             (!keeps || is_seen(&ask, &how))))
            continue;
        if (!renderer_rehearse(r, first[i], &how, ms, NULL))
            return false;
        haste_draft(h, forecast, &how, ms);
        return true;
    }
    return false;
}
