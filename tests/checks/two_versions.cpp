// Compiled against two versions of the library and linked into one program: two_versions.sh.
#include <cstdio>
#include <string>
#include <tilemesh/engine/mesh.hpp>

struct Wall : tilemesh::Channel<float, 1> {};
struct PushTwice {
    void operator()(tilemesh::In<Wall>, tilemesh::Out<Wall> out) const noexcept
    {
        for (int i = 0; i < 2; ++i) out[tilemesh::Direction::north].push(1);
    }
};

/// How the error begins that a kernel's broken contract ends the run with.
static std::string error_of_run()
{
    tilemesh::Mesh<tilemesh::Superstep<PushTwice>> mesh{{}, tilemesh::Grid{3, 2}, {.threads = 2}};
    try {
        mesh.run();
    } catch (tilemesh::Error const& error) {
        return std::string(error.what()).substr(0, 24);
    }
    return "no error";
}

#if defined(OTHER)
std::string error_of_other_version()
{
    return error_of_run();
}
#else
std::string error_of_other_version();
int main()
{
    auto const ours = error_of_run(), others = error_of_other_version();
    std::printf("this version: %s\nthe other version: %s\n", ours.c_str(), others.c_str());
    return ours == "push into a full channel" && others == "PUSH into a full channel" ? 0 : 1;
}
#endif
