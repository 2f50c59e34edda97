#include "options.hpp"

namespace track_bench {

Options parse(std::vector<std::string> const& all)
{
    Options options;
    for (bench::Words words(all); words.next();) {
        auto const& option = words.option();
        if (options.take(words, true)) continue;
        if (option == "--scene") options.scenes.push_back(words.one_of(scene_names));
        else if (option == "--table") options.tables.push_back(words.one_of(table_names));
        else if (option == "--method") options.methods.push_back(words.one_of(method_names));
        else if (option == "--trials") options.trials = words.number(1, 10'000);
        else if (option == "--rounds") options.rounds = words.number(1, 10'000);
        else words.refuse();
    }
    options.finish();
    if (options.quick) {
        options.trials = options.trials < 4 ? options.trials : 4;
        options.rounds = options.rounds < 3 ? options.rounds : 3;
        if (options.tables.empty()) options.tables = {"basin", "times", "model"};
        if (options.methods.empty()) options.methods = {"hybrid"};
    }
    return options;
}

std::string help()
{
    return std::string("Usage: track [options]\n"
                       "Finds the pose of a camera in a map: how far off a start may be, how exact the pose is, and what an evaluation costs.\n"
                       "\n"
                       "  --table NAME     basin    successes by start error, method, depth and cells, at 160 x 90\n"
                       "                   subsets  the same with one in so many blocks\n"
                       "                   spoilt   the error after noise, 8 bits, depth errors with holes and a change of exposure\n"
                       "                   times    ms of an evaluation and of a frame at 640 x 480, beside 13 renders of the same renderer\n"
                       "                   model    modelled ms on Mk2 at 640 x 480, by steps\n"
                       "                   may be repeated. Default: all\n"
                       "  --scene NAME     built_in, sloth or salad; may be repeated. Default: all\n"
                       "  --method NAME    hybrid, forward, gradient or esm, for the first three tables; may be repeated. Default: all\n"
                       "  --trials N       starts of each row. Default: 20\n"
                       "  --rounds N       measured rounds of times. Default: 9\n"
                       "  --quick          at most 4 starts and 3 rounds; unless named, hybrid on the built-in map, basin, times and model; 320 x 240\n"
                       "                   instead of 640 x 480\n"
                       "  --csv FILE       write the rows of basin: scene,method,depth,coarsest,one_in,degrees,trials,fine,near,evaluations,worst_degrees\n") +
           bench::help_of_data + "  --spoil          targets stand on their heads: the checks must fail\n  --help           this text\n\n" + bench::help_of_exit;
}

} // namespace track_bench
