// COMPILES
#include <tilemesh/tilemesh.hpp>

// Names that programs like to use for their own types, under a using-directive.
using namespace tilemesh;

struct Link : Channel<float, 1> {};
struct Road : Channel<float, 1> {};
struct Place : Buffer<float, 4> {};
struct Region : Buffer<float, 4> {};
struct Types { float x; };
struct Tag { float x; };
struct Name { float x; };
struct Role { float x; };
struct Peak { float x; };
struct Parameter { float x; };
struct Table { float x; };
struct Plot { float x; };
struct Bar { float x; };
struct Cell { float x; };
struct State { float x; };
struct Message { float x; };
struct List { float x; };
struct Mail { float x; };
struct Bank { float x; };
struct Map { float x; };
struct Image { float x; };
struct Camera { float x; };
struct LinkUse { float x; };
struct Needs { float x; };

struct Step {
    void operator()(Types& a, Tag& b, Name& c, Role& d, Peak& e, Parameter& f, Table& g, Plot& h, Bar& i, Cell& j, State& k, Message& l,
                    Place& place, Region& region, In<Link> in, Out<Link> out, In<Road>, Out<Road> road) const noexcept
    {
        for (auto side : news)
            for (float x : in[side]) a.x += x + b.x + c.x + d.x + e.x + f.x + g.x + h.x + i.x + j.x + k.x + l.x;
        place.truncate(0);
        region.truncate(0);
        out.to_all(a.x);
        road.to_all(a.x);
    }
    void others(List, Mail, Bank, Map, Image, Camera, LinkUse, Needs) const noexcept;
};

int main()
{
    Mesh mesh{Repeat<Step>{2}, Grid{2, 2}};
    mesh.run();
}
