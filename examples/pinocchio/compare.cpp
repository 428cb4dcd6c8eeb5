// Compares B2P2's model with pinocchio, in double precision: results and times.
//
// Both compute the same from the same random postures and motions, in alternating batches of one
// process. Every call starts from the joint values. `compare.py` builds and runs this program.

#include <pinocchio/algorithm/center-of-mass.hpp>
#include <pinocchio/algorithm/centroidal.hpp>
#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/kinematics.hpp>
#include <pinocchio/algorithm/rnea.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <random>
#include <vector>

namespace pin = pinocchio;

extern "C" {
struct Robot;
Robot *b2p2_new();
void b2p2_constants(double *constants);
void b2p2_frames(const Robot *, const double *q, double *frames);
void b2p2_cog(const Robot *, const double *q, double *cog);
void b2p2_inertia(const Robot *, const double *q, double *matrix);
void b2p2_coriolis(const Robot *, const double *q, const double *v, double *matrix);
void b2p2_inverse_dynamics(
    const Robot *, const double *q, const double *v, const double *a, double *forces);
void b2p2_zmp(const Robot *, const double *q, const double *v, const double *a, double *point);
}

constexpr int MOTIONS = 1000;
constexpr int ROUNDS = 301;

struct Motion {
    Eigen::VectorXd q{8}, v{8}, a{8};
};

// The Denavit-Hartenberg table of the paper's appendix (Khalil's convention). A turn about z or a
// shift along z that belongs to the table commutes with that of the joint.
pin::Model robot(const double *constants) {
    const double l1 = constants[0], l2 = constants[1], quarter = M_PI / 2;
    const struct { double alpha, d, theta, r; bool slides; } table[8] = {
        {-quarter, 0, quarter, 0, true},  {quarter, 0, quarter, 0, true},
        {-quarter, 0, -quarter, 0, true}, {0, 0, 0, 0, false},
        {-quarter, 0, -quarter, 0, false}, {-quarter, 0, -quarter, 0, false},
        {0, l1, quarter, 0, false},       {quarter, 0, 0, l2, true},
    };
    pin::Model model;
    pin::JointIndex parent = 0;
    for (int joint = 0; joint < 8; joint++) {
        const auto &row = table[joint];
        const Eigen::Matrix3d about_x(Eigen::AngleAxisd(row.alpha, Eigen::Vector3d::UnitX()));
        const Eigen::Matrix3d about_z(Eigen::AngleAxisd(row.theta, Eigen::Vector3d::UnitZ()));
        const pin::SE3 placement = pin::SE3(about_x, Eigen::Vector3d(row.d, 0, 0))
            * pin::SE3(about_z, Eigen::Vector3d(0, 0, row.r));
        const std::string name = "joint" + std::to_string(joint + 1);
        parent = row.slides ? model.addJoint(parent, pin::JointModelPZ(), placement, name)
                            : model.addJoint(parent, pin::JointModelRZ(), placement, name);
        if (joint >= 5) {
            const double *segment = constants + 3 + 13 * (joint - 5);
            const Eigen::Vector3d com(segment[1], segment[2], segment[3]);
            const Eigen::Matrix3d about_origin
                = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(segment + 4);
            const Eigen::Matrix3d shift
                = com.squaredNorm() * Eigen::Matrix3d::Identity() - com * com.transpose();
            const Eigen::Matrix3d about_com = about_origin - segment[0] * shift;
            model.appendBodyToJoint(parent, pin::Inertia(segment[0], com, about_com));
        }
    }
    model.gravity.linear() = Eigen::Vector3d(0, 0, -constants[2]);
    return model;
}

// Zero moment point on the plane z = 0, from the rate of the momentum about the centre of gravity.
Eigen::Vector3d zero_moment_point(const pin::Model &model, pin::Data &data, const Motion &motion) {
    pin::computeCentroidalMomentumTimeVariation(model, data, motion.q, motion.v, motion.a);
    const Eigen::Vector3d force = data.dhg.linear() - data.mass[0] * model.gravity.linear();
    const Eigen::Vector3d moment = data.dhg.angular() + data.com[0].cross(force);
    return Eigen::Vector3d(-moment[1] / force[2], moment[0] / force[2], 0);
}

double seconds() {
    timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return now.tv_sec + 1e-9 * now.tv_nsec;
}

double median(std::vector<double> &values) {
    std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
    return values[values.size() / 2];
}

// Sum of one element of every result, so that the compiler cannot leave out a call.
double sum = 0;

// Runs both functions over all motions, in alternating batches, and prints a row with the median
// times of a call. Both functions return an element of their result.

template<class Ours, class Theirs>
void compare(const char *name, const std::vector<Motion> &motions, double difference, Ours ours,
    Theirs theirs) {
    std::vector<double> our_times, their_times;
    for (int round = 0; round < ROUNDS; round++) {
        const double start = seconds();
        for (const Motion &motion : motions) sum += ours(motion);
        const double middle = seconds();
        for (const Motion &motion : motions) sum += theirs(motion);
        const double end = seconds();
        our_times.push_back((middle - start) / MOTIONS * 1e9);
        their_times.push_back((end - middle) / MOTIONS * 1e9);
    }
    const double we = median(our_times), they = median(their_times);
    std::printf("| %s | %.0f | %.0f | %.2f | %.0e |\n", name, we, they, we / they, difference);
}

// Largest difference over all motions.
template<class Difference>
double largest(const std::vector<Motion> &motions, Difference difference) {
    double found = 0;
    for (const Motion &motion : motions) {
        const double value = difference(motion);
        // A NaN must not look like a small difference.
        if (!(value <= found)) found = value;
    }
    return found;
}

int main() {
    double constants[42];
    b2p2_constants(constants);
    const pin::Model model = robot(constants);
    pin::Data data(model);
    const Robot *const ours = b2p2_new();

    std::mt19937_64 generator(1);
    std::uniform_real_distribution<double> unit(-1, 1);
    const double range[8] = {2, 2, 2, 3.1, 1.5, 1.5, 2.5, 0.3};
    std::vector<Motion> motions(MOTIONS);
    for (Motion &motion : motions)
        for (int joint = 0; joint < 8; joint++) {
            motion.q[joint] = range[joint] * unit(generator);
            motion.v[joint] = 2 * unit(generator);
            motion.a[joint] = 5 * unit(generator);
        }

    double frames[8][12];
    Eigen::Vector3d point;
    Eigen::VectorXd forces(8);
    Eigen::Matrix<double, 8, 8, Eigen::RowMajor> matrix;

    std::printf("| function | ours, ns | pinocchio, ns | ours / pinocchio | largest difference |\n"
                "|---|---|---|---|---|\n");
    const auto our_frames = [&](const Motion &m) {
        b2p2_frames(ours, m.q.data(), frames[0]);
        return frames[7][11];
    };
    const auto their_frames = [&](const Motion &m) {
        pin::forwardKinematics(model, data, m.q);
        return data.oMi[8].translation()[2];
    };
    const double frames_differ = largest(motions, [&](const Motion &m) {
        our_frames(m), their_frames(m);
        double worst = 0;
        for (int joint = 0; joint < 8; joint++) {
            const Eigen::Map<Eigen::Matrix<double, 3, 4>> frame(frames[joint]);
            const pin::SE3 &other = data.oMi[joint + 1];
            worst = std::max({worst, (frame.leftCols<3>() - other.rotation()).cwiseAbs().maxCoeff(),
                (frame.col(3) - other.translation()).cwiseAbs().maxCoeff()});
        }
        return worst;
    });
    compare("forward kinematics (8 frames)", motions, frames_differ, our_frames, their_frames);

    const auto our_cog = [&](const Motion &m) {
        b2p2_cog(ours, m.q.data(), point.data());
        return point[2];
    };
    const auto their_cog = [&](const Motion &m) {
        return pin::centerOfMass(model, data, m.q, false)[2];
    };
    const double cog_differs = largest(motions, [&](const Motion &m) {
        our_cog(m), their_cog(m);
        return (point - data.com[0]).cwiseAbs().maxCoeff();
    });
    compare("centre of gravity", motions, cog_differs, our_cog, their_cog);

    const auto our_inertia = [&](const Motion &m) {
        b2p2_inertia(ours, m.q.data(), matrix.data());
        return matrix(3, 7);
    };
    const auto their_inertia = [&](const Motion &m) {
        return pin::crba(model, data, m.q, pin::Convention::LOCAL)(3, 7);
    };
    const double inertia_differs = largest(motions, [&](const Motion &m) {
        our_inertia(m), their_inertia(m);
        data.M.triangularView<Eigen::StrictlyLower>()
            = data.M.transpose().triangularView<Eigen::StrictlyLower>();
        return (matrix - data.M).cwiseAbs().maxCoeff();
    });
    compare("inertia matrix D", motions, inertia_differs, our_inertia, their_inertia);

    const auto our_coriolis = [&](const Motion &m) {
        b2p2_coriolis(ours, m.q.data(), m.v.data(), matrix.data());
        return matrix(3, 7);
    };
    const auto their_coriolis = [&](const Motion &m) {
        return pin::computeCoriolisMatrix(model, data, m.q, m.v)(3, 7);
    };
    const double coriolis_differs = largest(motions, [&](const Motion &m) {
        our_coriolis(m), their_coriolis(m);
        return (matrix - data.C).cwiseAbs().maxCoeff();
    });
    compare("Coriolis matrix C", motions, coriolis_differs, our_coriolis, their_coriolis);

    const auto our_forces = [&](const Motion &m) {
        b2p2_inverse_dynamics(ours, m.q.data(), m.v.data(), m.a.data(), forces.data());
        return forces[7];
    };
    const auto their_forces
        = [&](const Motion &m) { return pin::rnea(model, data, m.q, m.v, m.a)[7]; };
    const double forces_differ = largest(motions, [&](const Motion &m) {
        our_forces(m), their_forces(m);
        return (forces - data.tau).cwiseAbs().maxCoeff();
    });
    compare("inverse dynamics", motions, forces_differ, our_forces, their_forces);

    const auto our_zmp = [&](const Motion &m) {
        b2p2_zmp(ours, m.q.data(), m.v.data(), m.a.data(), point.data());
        return point[0];
    };
    const auto their_zmp = [&](const Motion &m) { return zero_moment_point(model, data, m)[0]; };
    const double zmp_differs = largest(motions, [&](const Motion &m) {
        our_zmp(m);
        return (point - zero_moment_point(model, data, m)).cwiseAbs().maxCoeff();
    });
    compare("zero moment point from q, v, a", motions, zmp_differs, our_zmp, their_zmp);

    const double worst = std::max({frames_differ, cog_differs, inertia_differs, coriolis_differs,
        forces_differ, zmp_differs});
    if (!(worst <= 1e-10)) {
        std::fprintf(stderr, "the results differ by up to %.1e\n", worst);
        return 1;
    }
    if (!std::isfinite(sum)) {
        std::fprintf(stderr, "a result is not finite\n");
        return 1;
    }
    return 0;
}
