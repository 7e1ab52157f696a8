MODULE WbEgm
    ! One arm, led by the robot link abb-egm; loaded into both motion tasks.
    ! References come by EGM, orders beside them; nothing here moves the arm by itself.

    ! What the sensor's side says: version, ticket, order, command, opening in mm,
    ! whether it closes on a part, leg, and the load on the wrist after that: mass in kg,
    ! centre of gravity in mm, axes, inertia in kg m2; no mass where none is told.
    TASK PERS dnum wb_from{40};

    ! Tool and part together: EGM begins with it, so it stays when the controller starts
    ! anew.  Write the load of your tool here; a plan sets it that states one.
    TASK PERS loaddata wb_carried:=[0.001,[0,0,0.001],[1,0,0,0],0,0,0];

    ! What is answered: version, the ticket that was begun last, the order that was
    ! done last, the ticket that was refused last since it had been begun before.
    TASK PERS dnum wb_to{40};

    ! The last tickets that were begun.  They stay when the controller starts anew:
    ! nothing is begun twice.
    CONST num WB_TICKETS:=16;
    TASK PERS dnum wb_begun{16};
    TASK PERS num wb_begins:=0;

    CONST num WB_BEGIN:=1;
    CONST num WB_GRIP:=2;
    CONST num WB_END:=3;

    ! Without a message for so long (s) EGM ends.  The arm stands at the last
    ! reference meanwhile.
    CONST num WB_SILENCE:=2;

    ! Joints stand still between legs and while hands close: that must not end EGM.
    CONST num WB_LONG:=2000000;
    CONST egm_minmax WB_CLOSE:=[-0.05,0.05];

    CONST num WB_FILTER:=100;
    CONST num WB_FASTEST:=400;
    CONST num WB_FORCE:=10;
    CONST num WB_FINGER_SPEED:=20;
    CONST num WB_FINGER_STROKE:=25;
    CONST speeddata wb_slow:=[50,15,50,15];

    VAR egmident wb_guide;
    VAR egmident wb_states;
    VAR intnum wb_looks;

    ! An order is done at the second look that finds it: a message may come while
    ! the first one reads.
    VAR num wb_seen:=0;

    ! Between the orders to begin and to end.
    VAR bool wb_runs:=FALSE;

    ! Runs for ever. Begins anew when the operator sets the pointer to main.
    PROC wb_obey()
        wb_runs:=FALSE;
        wb_to{1}:=1;
        IF NOT Hand_IsCalibrated() THEN
            Hand_Initialize\maxSpd:=WB_FINGER_SPEED,\holdForce:=WB_FORCE,\Calibrate;
        ENDIF
        GripLoad wb_carried;
        ! EGM wants a fine point before it; the arm stays where it is.
        MoveAbsJ CJointT(),wb_slow,fine,tool0;
        EGMReset wb_states;
        EGMGetId wb_states;
        wb_join wb_states,my_states;
        EGMStreamStart wb_states\SampleRate:=100;
        IDelete wb_looks;
        CONNECT wb_looks WITH wb_look;
        ITimer 0.1,wb_looks;
        WHILE TRUE DO
            be_guided;
        ENDWHILE
    ENDPROC

    ! Until nobody is heard.  In the middle of a plan that is a fault: a person looks
    ! before the arm can be led again.
    PROC be_guided()
        EGMReset wb_guide;
        EGMGetId wb_guide;
        wb_join wb_guide,my_device;
        EGMActJoint wb_guide\DataToSensor:=wb_to\DataFromSensor:=wb_from\J1:=WB_CLOSE\J2:=WB_CLOSE\J3:=WB_CLOSE\J4:=WB_CLOSE\J5:=WB_CLOSE\J6:=WB_CLOSE\J7:=WB_CLOSE\LpFilter:=WB_FILTER\SampleRate:=4\MaxSpeedDeviation:=WB_FASTEST;
        EGMRunJoint wb_guide,EGM_STOP_HOLD\J1\J2\J3\J4\J5\J6\J7\CondTime:=WB_LONG;
    ERROR
        IF ERRNO=ERR_UDPUC_COMM THEN
            IF wb_runs THEN
                wb_runs:=FALSE;
                TPWrite "Workbench: nothing was heard, the "+my_name+" arm stands";
                Stop;
            ENDIF
            TRYNEXT;
        ENDIF
        RAISE;
    ENDPROC

    TRAP wb_look
        VAR num number;
        VAR num command;

        IF wb_from{1}<>1 RETURN;
        number:=DnumToNum(wb_from{3});
        command:=DnumToNum(wb_from{4});
        IF number<>wb_seen THEN
            wb_seen:=number;
            RETURN;
        ENDIF
        IF command=WB_BEGIN AND wb_from{2}<>wb_to{2} THEN
            IF is_begun(wb_from{2}) THEN
                wb_to{4}:=wb_from{2};
                RETURN;
            ENDIF
            wb_begins:=wb_begins MOD WB_TICKETS+1;
            wb_begun{wb_begins}:=wb_from{2};
            wb_to{3}:=0;
            wb_to{2}:=wb_from{2};
            wb_runs:=TRUE;
        ENDIF
        IF wb_from{2}<>wb_to{2} OR number<=DnumToNum(wb_to{3}) RETURN;
        ! After a fault of the hand nothing is done but to end.
        IF (NOT wb_runs) AND command<>WB_END RETURN;
        TEST command
        CASE WB_BEGIN:
        CASE WB_GRIP:
            IF NOT has_set_fingers(DnumToNum(wb_from{5}),wb_from{6}=1) THEN
                wb_runs:=FALSE;
                RETURN;
            ENDIF
            IF wb_from{8}>0 take_load;
        CASE WB_END:
            wb_runs:=FALSE;
        DEFAULT:
            RETURN;
        ENDTEST
        wb_to{3}:=wb_from{3};
    ENDTRAP

    PROC take_load()
        wb_carried.mass:=DnumToNum(wb_from{8});
        wb_carried.cog:=[DnumToNum(wb_from{9}),DnumToNum(wb_from{10}),DnumToNum(wb_from{11})];
        wb_carried.aom:=[DnumToNum(wb_from{12}),DnumToNum(wb_from{13}),DnumToNum(wb_from{14}),DnumToNum(wb_from{15})];
        wb_carried.ix:=DnumToNum(wb_from{16});
        wb_carried.iy:=DnumToNum(wb_from{17});
        wb_carried.iz:=DnumToNum(wb_from{18});
        GripLoad wb_carried;
    ENDPROC

    FUNC bool is_begun(dnum ticket)
        FOR k FROM 1 TO WB_TICKETS DO
            IF wb_begun{k}=ticket RETURN TRUE;
        ENDFOR
        RETURN FALSE;
    ENDFUNC

    ! The Smart Gripper counts what one finger travels: half of the opening.
    FUNC bool has_set_fingers(num opening,bool on_part)
        IF on_part THEN
            Hand_GripInward\holdForce:=WB_FORCE;
        ELSE
            Hand_MoveTo Min(opening/2,WB_FINGER_STROKE);
        ENDIF
        RETURN TRUE;
    ERROR
        TPWrite "Workbench: the hand of the "+my_name+" arm has a fault";
        RETURN FALSE;
    ENDFUNC
ENDMODULE
